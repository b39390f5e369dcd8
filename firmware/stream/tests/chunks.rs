//! Records in chunks of depth: the bits of whole records, and the faults of chunks.

mod common;

use std::sync::LazyLock;

use bonebeam_stream::scan::{self, BEAMS, ELEMENTS, Reference, SAMPLES, ScanMemory};
use bonebeam_stream::{Block, Chain, Chunks, Fault, Overflow, Pool, Probe, Sequence, Stamp};
use common::by_the_core;

type Record<const C: usize> = Chunks<[i16; 2], ELEMENTS, SAMPLES, C>;

/// The records of a frame, which take long to simulate.
static ECHOES: LazyLock<Vec<[[[i16; 2]; ELEMENTS]; SAMPLES]>> =
    LazyLock::new(|| (0..BEAMS).map(scan::echoes).collect());

/// Chunk `index` of a frame, and behind its record's end what a front end may have left there.
fn chunk<const C: usize>(index: usize) -> Block<[i16; 2], ELEMENTS, C> {
    let count = usize::from(Record::<C>::COUNT);
    let echoes = &ECHOES[index / count % BEAMS];
    let first = index % count * C;
    let mut chunk = Block::filled([i16::MIN; 2]);
    chunk.header.sequence = index as u32;
    chunk.header.beam = (index % (BEAMS * count)) as u16;
    for (row, echoes) in chunk.samples.iter_mut().zip(&echoes[first..]) {
        *row = *echoes;
    }
    chunk
}

/// A frame through pool, sequence and chain in chunks of `C` samples: image and map.
fn frame<const C: usize>() -> (Vec<f32>, Vec<f32>) {
    let (plan, mut memory) = (Reference::plan().unwrap(), Box::new(ScanMemory::new()));
    let mut chain = Chain::<Reference, BEAMS>::new(&plan, memory.scratch()).unwrap();
    let pool = Pool::<_, 2, 3>::new([const { Block::<[i16; 2], ELEMENTS, C>::filled([0; 2]) }; 2]);
    let (mut source, mut sink) = Box::leak(Box::new(pool)).split();
    let chunks = BEAMS * usize::from(Record::<C>::COUNT);
    let mut sequence = Sequence::new(chunks as u16);
    let mut record = Box::new(Record::<C>::new([0; 2]));
    for index in 0..chunks {
        source.begin().unwrap().clone_from(&chunk(index));
        source.complete(index as u32);
        let chunk = sink.receive().unwrap();
        let verdict = sequence.check(chunk.header);
        assert_eq!(verdict.faults, [None; 2]);
        if let Some((block, saturated)) = record.receive(verdict.line.unwrap(), &chunk, 8191) {
            assert_eq!(
                saturated,
                block.saturated(8191),
                "beam {}",
                block.header.beam
            );
            let time = chunk.time();
            let stamp = Stamp { time, saturated };
            let own = scan::record(block).unwrap();
            chain.line(block.header.beam.into(), &own, stamp).unwrap();
        }
        assert_eq!(verdict.whole, index + 1 == chunks);
    }
    let image = chain.image().unwrap();
    assert_eq!(image.missing, 0);
    let pixels = image.pixels.to_vec();
    (pixels, chain.map().unwrap().to_vec())
}

/// In chunks that divide a record and in chunks that do not, of one sample and of more than there are.
#[test]
fn any_chunks_have_the_bits_of_whole_records() {
    let whole = by_the_core().unwrap();
    assert!(frame::<1>() == whole, "1");
    assert!(frame::<40>() == whole, "40");
    assert!(frame::<64>() == whole, "64");
    assert!(frame::<279>() == whole, "279");
    assert!(frame::<SAMPLES>() == whole, "{SAMPLES}");
    assert!(frame::<300>() == whole, "300");
}

/// Small records: 5 samples in chunks of 2, 3 beams.
type Small = Chunks<i16, 2, 5, 2>;

fn small(index: u16) -> Block<i16, 2, 2> {
    let mut chunk = Block::filled(index as i16);
    chunk.header.sequence = index.into();
    chunk.header.beam = index % 9;
    chunk
}

/// Runs chunks; returns the faults and the samples of each record that is handed out.
fn run(chunks: &[Block<i16, 2, 2>]) -> (Vec<Fault>, Vec<(u16, Vec<i16>)>) {
    let mut sequence = Sequence::new(3 * Small::COUNT);
    let mut record = Small::new(-1);
    let (mut faults, mut records) = (vec![], vec![]);
    for chunk in chunks {
        let verdict = sequence.check(chunk.header);
        faults.extend(verdict.faults.into_iter().flatten());
        let received = verdict.line.and_then(|line| record.receive(line, chunk, 9));
        let samples = |(block, _): (&Block<i16, 2, 5>, _)| {
            let column = block.samples.iter().map(|row| row[0]);
            (block.header.beam, column.collect())
        };
        records.extend(received.map(samples));
    }
    (faults, records)
}

/// A record whose chunks are `first` to `first + 2`.
fn expected(beam: u16, first: i16) -> (u16, Vec<i16>) {
    let [a, b, c] = [0, 1, 2].map(|k| first + k);
    (beam, vec![a, a, b, b, c])
}

#[test]
fn lost_and_repeated_chunks_are_faults_from_the_first_one_on() {
    let beams = [expected(0, 0), expected(1, 3), expected(2, 6)];
    let good: Vec<_> = (0..9).map(small).collect();
    assert_eq!(run(&good), (vec![], beams.to_vec()));
    for at in 0..9u16 {
        let mut twice = good.clone();
        twice.insert(at.into(), small(at));
        let (expected, got) = (u32::from(at) + 1, at.into());
        // The first block again is a restart.
        let fault = match at {
            0 => Fault::Restarted { expected, got },
            _ => Fault::Repeated { expected, got },
        };
        assert_eq!(run(&twice), (vec![fault], beams.to_vec()), "{at} twice");
    }
    for at in 0..8u16 {
        let mut lost = good.clone();
        lost.remove(at.into());
        let fault = match at {
            // Nothing came before it: the frame begins anew with beam 0.
            0 => None,
            _ => Some(Fault::Lost {
                expected: at.into(),
                got: u32::from(at) + 1,
            }),
        };
        let (faults, records) = run(&lost);
        assert_eq!(faults, Vec::from_iter(fault), "{at} lost");
        assert_eq!(records, beams[..usize::from(at / 3)], "{at} lost");
    }
    let mut clipped = good.clone();
    clipped[4].header.overflow = Overflow::CLIPPED;
    let overflow = Overflow::CLIPPED;
    let fault = Fault::Overflowed {
        sequence: 4,
        overflow,
    };
    assert_eq!(run(&clipped), (vec![fault], beams[..1].to_vec()));
}

/// Without a sequence in front of it, too.
#[test]
fn a_record_with_a_gap_is_not_handed_out() {
    let mut record = Small::new(0);
    let mut receive = |index| {
        let received = record.receive(index, &small(index), 9);
        received.map(|(block, saturated)| (block.header.beam, block.header.sequence, saturated))
    };
    for index in [1, 2, 0, 2, 0, 1, 1, 2, 3, 4] {
        assert_eq!(receive(index), None, "{index}");
    }
    assert_eq!(receive(5), Some((1, 5, 0)));
    assert_eq!(receive(5), None);
    // Two samples of each of two rows; of the last chunk one row is the record's.
    for (index, saturated) in [(9, 0), (10, 0), (11, 10)] {
        let received = receive(index);
        assert_eq!(received, (saturated > 0).then_some((3, 11, saturated)));
    }
}
