//! `host-sim serve`: pictures from OpenIGTLink → bone to OpenIGTLink, live.

use std::collections::BTreeMap;
use std::io::{self, BufReader, Write};
use std::net::{IpAddr, Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use clap::{Args, ValueEnum};
use ndarray::Array2;

use super::sequence::PlaceArguments;
use super::surface_files::Overlay;
use crate::flags::Flags;
use crate::{Error, Result};
use bonebeam_drive::config::Surface;
use bonebeam_files::terminal::{print, remark};
use bonebeam_tracked::{
    Euler, Finder, Image, Live, Matrix, Message, apply, image_content, point_content,
    polydata_content,
};

/// Longest silence within a message, and longest time in which an end reads nothing.
const PATIENCE: Duration = Duration::from_secs(5);
/// Most ends at a time, and most reasons that are told apart.
const MOST_ENDS: usize = 8;
const MOST_REASONS: usize = 32;
/// Answers that wait for an end which reads slowly; later ones are not sent to it.
const WAITING: usize = 1;

/// Find the bone surface in pictures from OpenIGTLink, live.
///
/// Takes IMAGE, with TRANSFORM messages whose device is the transform's name, such as ProbeToTracker, or with the
/// transforms in its metadata. Without --calibration and --to, the matrix of each IMAGE is its pose. All ends get the
/// answers, in the frame of reference (RAS, mm), with the picture's time and header version. Pictures that cannot be
/// kept up with are dropped and counted.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, allow_negative_numbers = true)]
pub struct Arguments {
    /// Port to listen on; 0 is a free one, which is printed
    #[arg(long, default_value_t = 18944)]
    port: u16,

    /// Address to listen on; there is no access control
    #[arg(long, value_name = "IP", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    address: IpAddr,

    /// Also take pictures from a server, such as PLUS, until it ends
    #[arg(long, value_name = "HOST:PORT")]
    connect: Option<String>,

    /// Device whose IMAGE messages are used [default: all]
    #[arg(long, value_name = "NAME")]
    device: Option<String>,

    /// Answers to send
    #[arg(
        long,
        value_name = "ANSWER,…",
        value_delimiter = ',',
        num_args = 1,
        default_value = "polydata,point,picture"
    )]
    send: Vec<Answer>,

    #[command(flatten)]
    place: PlaceArguments,

    #[command(flatten)]
    surface: Flags<Surface>,
}

const EXAMPLES: &str = "\
Examples:
  host-sim serve --send polydata,point
  host-sim serve --calibration PlusConfiguration.xml --to Reference
  host-sim serve --connect localhost:18944 --port 18945 --device Image_Reference";

/// An answer to a picture.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Answer {
    /// POLYDATA Bone: the surface as lines, with the confidence of each point
    Polydata,
    /// POINT BonePoints: the points, named by their confidence
    Point,
    /// IMAGE BonePicture: the picture with the surface drawn over it
    Picture,
    /// IMAGE BoneMap: the confidence along the surface, 1 to 255, on 0
    Map,
}

/// Runs the command.
///
/// # Errors
/// A flag out of range, a port that is taken, or a server that cannot be reached or breaks off.
pub fn run(arguments: Arguments) -> Result<()> {
    let mut surface = Surface::default();
    arguments.surface.apply(&mut surface);
    surface.validate()?;
    let place = &arguments.place;
    let calibration = place.calibration(Euler::default())?;
    let (address, port) = (arguments.address, arguments.port);
    let listener = TcpListener::bind((address, port)).and_then(|own| Ok((own.local_addr()?, own)));
    let (address, listener) =
        listener.map_err(|e| failed(&format!("listen on {address}:{port}"), e))?;
    let hub = Arc::new(Hub {
        device: arguments.device.clone(),
        poses: Live::new(
            calibration,
            place.target().map(String::from),
            place.pixel()?,
        ),
        ..Hub::default()
    });
    if let Some(server) = &arguments.connect {
        let failed = |e| failed(&format!("connect to {server}"), e);
        let stream = TcpStream::connect(server).map_err(failed)?;
        let end = hub.join(stream, server.clone()).map_err(failed)?;
        let hub = hub.clone();
        spawn(move || {
            let ended = end.join().unwrap_or_default();
            hub.state().ended = Some(ended);
            hub.changed.notify_all();
        })
        .map_err(failed)?;
    }
    print(&format!("listening on {address}\n"))?;
    let accepting = hub.clone();
    let accept = move || {
        for stream in listener.incoming() {
            let join = |stream: TcpStream| {
                accepting.join(stream.try_clone()?, stream.peer_addr()?.to_string())
            };
            if let Err(e) = stream.and_then(join) {
                remark(&format!("an end is refused: {e}"));
                thread::sleep(Duration::from_millis(100));
            }
        }
    };
    spawn(accept).map_err(|e| failed("start a thread", e))?;
    let mut finder = None;
    while let Some((job, end)) = hub.next() {
        match answers(&mut finder, &job, &arguments, &surface) {
            Ok(bytes) => {
                hub.send(&Arc::new(bytes));
                end.counts().answered += 1;
            }
            Err(reason) => end.leave_out(reason),
        }
    }
    let ended = hub.state().ended.take().flatten();
    let server = arguments.connect.unwrap_or_default();
    ended.map_or(Ok(()), |message| {
        Err(Error::Data(format!("{server} {message}")))
    })
}

fn failed(what: &str, e: io::Error) -> Error {
    Error::Data(format!("cannot {what}: {e}"))
}

fn spawn<T: Send + 'static>(
    work: impl FnOnce() -> T + Send + 'static,
) -> io::Result<JoinHandle<T>> {
    thread::Builder::new().spawn(work)
}

/// A picture with its pose and the sides of a pixel, mm.
struct Job {
    image: Image,
    pose: Matrix,
    pixel: [f64; 2],
}

/// An end of the connection, and what came from it.
struct End {
    name: String,
    counts: Mutex<Counts>,
}

#[derive(Default)]
struct Counts {
    pictures: u64,
    answered: u64,
    dropped: u64,
    unread: u64,
    left_out: BTreeMap<String, u64>,
}

impl Counts {
    fn left_out(&self) -> u64 {
        self.left_out.values().sum()
    }
}

impl End {
    fn counts(&self) -> MutexGuard<'_, Counts> {
        self.counts.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Counts a picture that is left out, and prints a reason when it is new.
    fn leave_out(&self, mut reason: String) {
        let mut counts = self.counts();
        if counts.left_out.len() >= MOST_REASONS {
            reason = "other reasons".into();
        }
        let count = counts.left_out.entry(reason.clone()).or_default();
        *count += 1;
        if *count == 1 {
            remark(&format!("{}: a picture is left out: {reason}", self.name));
        }
    }

    fn is_waiting(&self) -> bool {
        let counts = self.counts();
        counts.pictures > counts.answered + counts.dropped + counts.left_out()
    }

    fn tell_end(&self, reason: &str) {
        let counts = self.counts();
        let (left_out, name) = (counts.left_out(), &self.name);
        let Counts {
            pictures,
            answered,
            dropped,
            unread,
            ..
        } = *counts;
        remark(&format!(
            "{name} {reason}: {pictures} pictures, {answered} answered, {dropped} dropped, {left_out} left out; \
             {unread} answers not read"
        ));
    }
}

/// The messages for a picture.
type Answers = Arc<Vec<u8>>;

/// The newest picture, and the ends that get the answers.
#[derive(Default)]
struct Hub {
    state: Mutex<State>,
    changed: Condvar,
    device: Option<String>,
    poses: Live,
}

#[derive(Default)]
struct State {
    job: Option<(Job, Arc<End>)>,
    /// Whether the server has ended, and its error.
    ended: Option<Option<String>>,
    ends: Vec<(Arc<End>, SyncSender<Answers>)>,
}

impl Hub {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Begins to serve an end; the thread returns its error.
    fn join(
        self: &Arc<Self>,
        mut stream: TcpStream,
        name: String,
    ) -> io::Result<JoinHandle<Option<String>>> {
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let reader = stream.try_clone()?;
        let (sender, receiver) = sync_channel::<Answers>(WAITING);
        let counts = Mutex::default();
        let (hub, end) = (self.clone(), Arc::new(End { name, counts }));
        let mut state = self.state();
        if state.ends.len() >= MOST_ENDS {
            return Err(io::Error::other(format!("{MOST_ENDS} are connected")));
        }
        spawn(move || {
            let sent = receiver
                .into_iter()
                .try_for_each(|bytes| stream.write_all(&bytes));
            // Without a reader at the other end the reading stops, too.
            let _ = stream.shutdown(if sent.is_ok() {
                Shutdown::Write
            } else {
                Shutdown::Both
            });
        })?;
        state.ends.push((end.clone(), sender));
        spawn(move || {
            let ended = hub.read(reader, &end).err();
            hub.state().ends.retain(|(own, _)| !Arc::ptr_eq(own, &end));
            end.tell_end(ended.as_deref().unwrap_or("is gone"));
            ended
        })
    }

    /// Reads an end's messages until it ends.
    fn read(&self, stream: TcpStream, end: &Arc<End>) -> std::result::Result<(), String> {
        let mut stream = BufReader::with_capacity(1 << 16, stream);
        let mut poses = self.poses.clone();
        // A picture whose transforms may follow it.
        let mut waiting: Option<Image> = None;
        while let Some(message) = Message::read(&mut stream)? {
            let is_ours = self
                .device
                .as_ref()
                .is_none_or(|device| *device == message.name);
            match &message.kind[..] {
                "TRANSFORM" => poses.add(&message)?,
                "IMAGE" if is_ours => {
                    self.hand(waiting.take(), &poses, end);
                    end.counts().pictures += 1;
                    waiting = Image::of(message)
                        .map_err(|reason| end.leave_out(reason))
                        .ok();
                }
                _ => {}
            }
            self.hand(waiting.take_if(|image| poses.is_ready(image)), &poses, end);
        }
        self.hand(waiting, &poses, end);
        // An end may stop sending and still wait for its answers.
        drop(
            self.changed
                .wait_timeout_while(self.state(), PATIENCE, |_| end.is_waiting()),
        );
        Ok(())
    }

    /// Makes a picture the next one; one that was waiting is dropped.
    fn hand(&self, image: Option<Image>, poses: &Live, end: &Arc<End>) {
        let Some(image) = image else { return };
        match poses.pose(&image) {
            Ok((pose, pixel)) => {
                let before = self
                    .state()
                    .job
                    .replace((Job { image, pose, pixel }, end.clone()));
                if let Some((_, end)) = before {
                    end.counts().dropped += 1;
                }
                self.changed.notify_all();
            }
            Err(reason) => end.leave_out(reason),
        }
    }

    /// Waits for the next picture; `None` once the server has ended.
    fn next(&self) -> Option<(Job, Arc<End>)> {
        // The last picture is done.
        self.changed.notify_all();
        let idle = |state: &mut State| state.job.is_none() && state.ended.is_none();
        let state = self.changed.wait_while(self.state(), idle);
        state.unwrap_or_else(PoisonError::into_inner).job.take()
    }

    /// Sends answers to all ends that keep up.
    fn send(&self, bytes: &Answers) {
        for (end, sender) in &self.state().ends {
            if let Err(TrySendError::Full(_)) = sender.try_send(bytes.clone()) {
                end.counts().unread += 1;
            }
        }
    }
}

/// The messages for a picture.
fn answers(
    finder: &mut Option<Finder>,
    job: &Job,
    arguments: &Arguments,
    surface: &Surface,
) -> std::result::Result<Vec<u8>, String> {
    let Job { image, pose, pixel } = job;
    let pixels = image.pixels()?;
    let text = |e: Error| e.to_string();
    let finder = match finder {
        Some(finder) if finder.is_for(image.sides, *pixel) => finder,
        other => other.insert(
            Finder::of(surface, arguments.place.part(), image.sides, *pixel).map_err(text)?,
        ),
    };
    if finder.show(&pixels) {
        finder.settle().map_err(text)?;
    }
    let pixels = finder.part_of(pixels);
    let found = finder.search(&pixels).map_err(text)?;
    let points = finder.points(&found.points, image.message.id as usize, pose);
    let [x, y, columns, rows] = finder.part();
    let mut placed = *pose;
    let corner = apply(pose, [x as f64, y as f64, 0.0]);
    placed
        .iter_mut()
        .zip(corner)
        .for_each(|(row, value)| row[3] = value);
    let drawn = |pixels: Array2<f32>, fan, colour| {
        let picture = finder.image(pixels);
        Overlay::of(&picture, fan, &found.points, colour).pixels
    };
    let answer = |answer: &Answer| {
        let (kind, name, content) = match answer {
            Answer::Polydata => {
                let pieces = found
                    .points
                    .chunk_by(|a, b| a.piece == b.piece)
                    .map(<[_]>::len);
                (
                    "POLYDATA",
                    "Bone",
                    polydata_content(&points, &pieces.collect::<Vec<_>>()),
                )
            }
            Answer::Point => (
                "POINT",
                "BonePoints",
                point_content(&points, &image.message.name),
            ),
            Answer::Picture => {
                let picture = drawn(pixels.clone(), found.fan.as_ref(), Overlay::colour);
                let bytes = picture.as_slice().unwrap_or_default().as_flattened();
                (
                    "IMAGE",
                    "BonePicture",
                    image_content(bytes, [columns, rows], &placed),
                )
            }
            Answer::Map => {
                let level = |confidence: f32| [(1.0 + 254.0 * confidence) as u8; 3];
                let map = drawn(Array2::zeros((rows, columns)), None, level);
                let bytes: Vec<u8> = map.into_iter().map(|[level, ..]| level).collect();
                (
                    "IMAGE",
                    "BoneMap",
                    image_content(&bytes, [columns, rows], &placed),
                )
            }
        };
        let Message {
            version, time, id, ..
        } = image.message;
        let (kind, name, metadata) = (kind.into(), name.into(), Vec::new());
        Message {
            version,
            kind,
            name,
            time,
            id,
            content,
            metadata,
        }
        .bytes()
    };
    Ok(arguments
        .send
        .iter()
        .map(answer)
        .collect::<Vec<_>>()
        .concat())
}
