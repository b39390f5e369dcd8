//! Limits and signals of the system, special files, and the environment.

use crate::common::channel_data_without;
use crate::common::program::{
    BEAMFORM, DATA, Folder, USAGE, ended, folder_with_channel_data, names, program, run, shell,
    succeeded,
};
use std::fs;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::{TempDir, tempdir};

/// The message of a run that was refused in one line and left nothing; `None` if it succeeded.
fn refusal(folder: &TempDir, script: &str) -> Option<String> {
    let before = names(folder.path());
    let (status, _, message) = ended(&mut shell(folder, script));
    if status == 0 {
        for name in names(folder.path()) {
            if !before.contains(&name) {
                fs::remove_file(folder.path().join(name)).unwrap();
            }
        }
        return None;
    }
    assert!(message.starts_with("host-sim: "), "{script}: {message}");
    assert_eq!(status, DATA, "{script}: {message}");
    assert_eq!(message.lines().count(), 1, "{script}: {message}");
    assert_eq!(names(folder.path()), before, "{script}: {message}");
    Some(message)
}

/// Any limit of address space: a run succeeds, or fails in one line.
///
/// The size check covers the image, its PNG, the bone map and the threads. If an allocation fails all the same, the
/// run reports an error and leaves nothing.
#[cfg(target_os = "linux")]
#[test]
fn any_limit_of_memory_is_one_line_and_leaves_nothing() {
    let folder = folder_with_channel_data();
    for (arguments, most) in [
        ("--image i.png --rows 4096 --columns 4096", 700),
        ("--image i.png --rows 4096 --columns 4096 --median", 700),
        ("--image i.svg --rows 2048 --columns 2048 --threads 8", 900),
        ("--bone-map map.png --rows 1024 --columns 1024", 600),
    ] {
        let run = |mb: u64| {
            let beamform = format!("beamform data.npz -o lines.npz {arguments}");
            let script = format!("ulimit -v {}; exec \"$0\" {beamform}", mb << 10);
            refusal(&folder, &script).is_none()
        };
        let outcomes: Vec<bool> = (40..most).step_by(71).map(run).collect();
        assert!(
            !outcomes[0] && outcomes[outcomes.len() - 1],
            "{arguments}: {outcomes:?}"
        );
    }
}

/// An abort, for example after a failed allocation, leaves no files either.
#[cfg(target_os = "linux")]
#[test]
fn an_abort_leaves_nothing() {
    let folder = folder_with_channel_data();
    let status = signalled(&folder, 6);
    assert_eq!(status, (Some(DATA), vec!["data.npz".to_owned()]));
}

/// A long run that has a temporary file now.
///
/// The tests themselves may run under `nohup`.
fn with_temporary_file(folder: &TempDir) -> Child {
    let script = "exec env --default-signal=HUP \"$0\" beamform data.npz -o lines.npz --image i.png --rows 8192 --columns 8192";
    let child = shell(folder, script)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let begin = Instant::now();
    while !names(folder.path())
        .iter()
        .any(|name| name.starts_with(".host-sim"))
    {
        assert!(
            begin.elapsed() < Duration::from_secs(60),
            "no temporary file"
        );
        std::thread::sleep(Duration::from_micros(200));
    }
    child
}

fn kill(child: &Child, signal: i32) {
    let arguments = [format!("-{signal}"), child.id().to_string()];
    assert!(
        Command::new("kill")
            .args(arguments)
            .status()
            .unwrap()
            .success()
    );
}

/// Status of a run that gets this signal, and the files in its folder then.
fn signalled(folder: &TempDir, signal: i32) -> (Option<i32>, Vec<String>) {
    let mut child = with_temporary_file(folder);
    kill(&child, signal);
    (child.wait().unwrap().code(), names(folder.path()))
}

#[cfg(target_os = "linux")]
#[test]
fn every_signal_that_ends_the_program_leaves_nothing() {
    const SIGNALS: [(&str, i32); 5] = [
        ("HUP", 1),
        ("INT", 2),
        ("QUIT", 3),
        ("TERM", 15),
        ("XCPU", 24),
    ];
    for (name, number) in SIGNALS {
        let folder = folder_with_channel_data();
        let (code, left) = signalled(&folder, number);
        assert_eq!(
            (code, left),
            (Some(128 + number), vec!["data.npz".to_owned()]),
            "SIG{name}"
        );
    }
    // The parent process may ignore a signal, as nohup does.
    let folder = folder_with_channel_data();
    let script = format!("trap '' HUP; \"$0\" {BEAMFORM} & sleep 0.01; kill -1 $!; wait $!");
    succeeded(&mut shell(&folder, &script));
}

/// An output that does not fit. The program itself ignores the signal of a file too large, without the shell.
///
/// The shell's limit on the size of a file stands in for a full disk: 64 blocks of 512 or 1024 bytes.
#[cfg(target_os = "linux")]
#[test]
fn a_limit_of_file_size_is_an_error() {
    let folder = folder_with_channel_data();
    folder.works("beamform data.npz -o lines.npz --line-count 1000");
    for arguments in [
        "simulate point --beams 3 -o big.npz",
        "beamform data.npz -o other.npz --image big.npy --rows 512",
        "convert lines.npz -o big.npz",
        "convert lines.npz -o big.hdf5",
        "convert lines.npz -o big.uff",
    ] {
        for ignored in ["", "trap '' XFSZ; "] {
            let script = format!("{ignored}ulimit -f 64; exec \"$0\" {arguments}");
            let message = refusal(&folder, &script).expect("a refusal");
            for part in ["big.", "cannot be written", "File too large"] {
                assert!(message.contains(part), "{message}");
            }
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn leftovers_of_processes_that_are_gone_are_removed() {
    let folder = folder_with_channel_data();
    let left = |name: &String| name.starts_with(".host-sim");
    fs::write(folder.path().join(".host-sim-1-7"), "of a killed run").unwrap();
    // The temporary file of another run that goes on, and files with similar names.
    let held = fs::File::create(folder.path().join(".host-sim-1-0")).unwrap();
    held.lock().unwrap();
    fs::write(folder.path().join(".host-sim-notes"), "mine").unwrap();
    succeeded(&mut program(&folder, BEAMFORM));
    let found: Vec<String> = names(folder.path()).into_iter().filter(left).collect();
    assert_eq!(found, [".host-sim-1-0", ".host-sim-notes"]);
}

#[cfg(target_os = "linux")]
#[test]
fn names_are_reported_without_escape_sequences() {
    let folder = tempdir().unwrap();
    let name = "a\u{1b}[31mb\nc\u{9b}\u{7f}.npz";
    channel_data_without(&folder.path().join(name), &[]).finish();
    fs::write(folder.path().join("list"), name).unwrap();
    for command in ["info \"$f\"", "beamform \"$f\" -o lines.npz --json"] {
        let script = format!("f=$(cat list); exec \"$0\" {command}");
        let [text, _] = succeeded(&mut shell(&folder, &script));
        let control = |c: char| c.is_control() && c != '\n';
        assert!(!text.contains(control), "{command}: {text:?}");
        let first = text.lines().next().unwrap();
        assert!(
            first.contains("[31mb\\nc") && first.contains(".npz"),
            "{command}: {first}"
        );
    }
}

#[test]
fn environment_variables_of_threads_are_checked() {
    let folder = folder_with_channel_data();
    for (name, values) in [
        ("RAYON_NUM_THREADS", ["many", "0", "-1", "100000"]),
        ("RUST_MIN_STACK", ["much", "1", "2MB", "99999999999999"]),
    ] {
        for value in values {
            let script = format!("{name}={value} exec \"$0\" {BEAMFORM}");
            let (status, _, message) = ended(&mut shell(&folder, &script));
            assert_eq!(status, USAGE, "{script}: {message}");
            let expected = format!("host-sim: {name} is {value}; expected ");
            assert!(message.starts_with(&expected), "{script}: {message}");
            assert_eq!(names(folder.path()), ["data.npz"]);
        }
    }
    let script = format!("RAYON_NUM_THREADS=3 RUST_MIN_STACK=4194304 exec \"$0\" {BEAMFORM}");
    succeeded(&mut shell(&folder, &script));
}

/// SonixDAQ samples have 16 bits in files and 32 in memory: both are counted.
#[cfg(target_os = "linux")]
#[test]
fn raw_bytes_of_a_sonix_daq_are_asked_for() {
    let folder = tempdir().unwrap();
    let daq = folder.path().join("daq");
    fs::create_dir(&daq).unwrap();
    let samples = 40_000_000;
    let header: Vec<u8> = [7i32, 1, samples]
        .iter()
        .flat_map(|n| n.to_le_bytes())
        .collect();
    fs::write(daq.join("CH000.daq"), header).unwrap();
    let file = fs::OpenOptions::new()
        .write(true)
        .open(daq.join("CH000.daq"))
        .unwrap();
    file.set_len(12 + 2 * samples as u64).unwrap();
    let info = "info daq --variable fs=40e6 --variable f0=6.6e6 --variable c=1540 --variable t0=0 \
                --variable pitch=0.3e-3 --variable tx_angle=0";
    let refused_within = |mb: u64| {
        let script = format!("ulimit -v {}; exec \"$0\" {info} --threads 1", mb << 10);
        let (status, _, message) = ended(&mut shell(&folder, &script));
        assert_eq!(message.lines().count(), 1, "{message}");
        assert_eq!(status, DATA, "{mb} MB: {message}");
    };
    (40..460).step_by(20).for_each(refused_within);
}

#[test]
fn the_data_of_these_tests_are_good_where_they_are_not_spoilt() {
    let folder = folder_with_channel_data();
    for method in [
        "das",
        "mv",
        "esmv --rank 1",
        "esmv --beta 0.1",
        "esmv-rank1",
    ] {
        let (code, message) = run(&folder, &format!("{BEAMFORM} --method {method}"));
        assert_eq!((code, message.as_str()), (0, ""));
    }
    assert_eq!(
        names(folder.path()),
        [
            "data.npz",
            "lines.npz",
            "lines.npz.config.toml",
            "lines.png"
        ]
    );
    let (code, message) = run(
        &folder,
        "phase-symmetry lines.png --pad -o ps.npy --image ps.png",
    );
    assert_eq!((code, message.as_str()), (0, ""));
    assert!(folder.path().join("ps.npy.config.toml").exists());
}

/// A workflow names each action by its commit, which cannot move.
///
/// The tag follows as a comment.
#[test]
fn actions_of_workflows_are_named_by_commits() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../.github/workflows");
    let mut actions = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let text = fs::read_to_string(entry.unwrap().path()).unwrap();
        for line in text.lines().filter(|line| line.contains("uses:")) {
            let (_, commit) = line.split_once('@').unwrap();
            let (commit, tag) = commit.split_once(" # v").unwrap_or((commit, ""));
            let hexadecimal = commit.len() == 40 && commit.bytes().all(|b| b.is_ascii_hexdigit());
            assert!(hexadecimal && !tag.is_empty(), "{line}");
            actions += 1;
        }
    }
    assert!(actions > 1);
}
