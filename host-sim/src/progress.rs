//! Progress of a computation: a bar on a terminal, else lines.

use std::io::{IsTerminal, Write, stderr};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use bonebeam_files::terminal::one_line;

/// Time between two updates of the bar.
const PERIOD: Duration = Duration::from_millis(50);
/// Time between two lines if there is no terminal.
const LINE: Duration = Duration::from_secs(60);
/// Width of the bar, characters.
const WIDTH: usize = 40;
/// The longest message, characters, so that a line stays within a terminal.
const LONGEST: usize = 60;

/// Progress on standard error: a bar, or one line per minute without a terminal.
pub struct Progress {
    terminal: bool,
    /// Whether each new message makes a line if there is no terminal.
    each_step: bool,
    begin: Instant,
    state: Mutex<State>,
}

struct State {
    message: String,
    done: u64,
    steps: u64,
    drawn: Option<Instant>,
    /// Message and time of the last line without a terminal.
    last_line: (String, Instant),
}

impl Progress {
    /// A bar of `steps` steps; if `steps` is 0, only the message is shown.
    pub fn new(message: &str, steps: u64) -> Self {
        let begin = Instant::now();
        Self {
            terminal: stderr().is_terminal(),
            each_step: false,
            begin,
            state: Mutex::new(State {
                message: message.to_owned(),
                done: 0,
                steps,
                drawn: None,
                last_line: (message.to_owned(), begin),
            }),
        }
    }

    /// As `new`, for work of many steps: without a terminal each message makes a line.
    pub fn of_steps(steps: u64) -> Self {
        Self {
            each_step: true,
            ..Progress::new("", steps)
        }
    }

    /// Sets the number of steps done and the number of all.
    pub fn set(&self, done: u64, steps: u64) {
        self.change(|state| (state.done, state.steps) = (done, steps));
    }

    /// Sets the message: the current step.
    pub fn set_message(&self, message: String) {
        self.change(|state| state.message = message);
    }

    /// Sets the current step, and the share of it that is done, in thousandths.
    pub fn set_step(&self, what: &str, done: f64) {
        let is_new = |state: &State| state.message != what;
        if is_new(&self.state.lock().unwrap_or_else(PoisonError::into_inner)) {
            self.set_message(what.to_owned());
        }
        self.set((1000.0 * done) as u64, 1000);
    }

    /// Removes the bar.
    pub fn clear(&self) {
        if self.terminal {
            write("\r\x1b[K");
        }
    }

    fn change(&self, change: impl FnOnce(&mut State)) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        change(&mut state);
        let now = Instant::now();
        if self.terminal {
            if state.is_due(now) {
                write(&format!("\r{}\x1b[K", state.line(now - self.begin)));
            }
        } else if state.line_is_due(now, self.each_step) {
            write(&format!("host-sim: {}\n", state.words(now - self.begin)));
        }
    }
}

/// Writes `text`; a terminal that fails does not end the computation.
fn write(text: &str) {
    let _ = stderr().lock().write_all(text.as_bytes());
}

impl State {
    /// Whether to draw at `now`: at most once a [`PERIOD`].
    fn is_due(&mut self, now: Instant) -> bool {
        let due = self.drawn.is_none_or(|drawn| now - drawn >= PERIOD);
        if due {
            self.drawn = Some(now);
        }
        due
    }

    /// Whether to write a line at `now`: once a [`LINE`], or also at each new message.
    fn line_is_due(&mut self, now: Instant, each_step: bool) -> bool {
        let (message, written) = &self.last_line;
        let due = now - *written >= LINE || (each_step && *message != self.message);
        if due {
            self.last_line = (self.message.clone(), now);
        }
        due
    }

    /// The share done, 0 to 1.
    fn fraction(&self) -> f64 {
        (self.done as f64 / self.steps.max(1) as f64).min(1.0)
    }

    /// Time left; empty if nothing is done yet.
    fn left(&self, elapsed: Duration) -> String {
        match self.done {
            0 => String::new(),
            _ => short(elapsed.as_secs_f64() * (1.0 / self.fraction() - 1.0)),
        }
    }

    /// The text of a line without a bar.
    fn words(&self, elapsed: Duration) -> String {
        let message = one_line(&self.message);
        if self.steps == 0 {
            return message;
        }
        let fraction = format!("{message}: {:.0} %", 100.0 * self.fraction());
        match &self.left(elapsed)[..] {
            "" => fraction,
            left => format!("{fraction}, {left} left"),
        }
    }

    fn line(&self, elapsed: Duration) -> String {
        let message: String = self.message.chars().take(LONGEST).collect();
        if self.steps == 0 {
            return message;
        }
        let fraction = self.fraction();
        let bar = "█".repeat((fraction * WIDTH as f64) as usize);
        let left = self.left(elapsed);
        format!(
            "{message:20} {bar:░<WIDTH$} {:>3.0} % {left:>4}",
            100.0 * fraction
        )
    }
}

/// Seconds in the largest unit of which there is one.
fn short(seconds: f64) -> String {
    match seconds {
        s if s < 60.0 => format!("{s:.0}s"),
        s if s < 3600.0 => format!("{:.0}m", s / 60.0),
        s => format!("{:.0}h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_the_share_that_is_done_and_the_time_that_is_left() {
        let mut state = State {
            message: "beamforming".into(),
            done: 250,
            steps: 1000,
            drawn: None,
            last_line: (String::new(), Instant::now()),
        };
        let line = state.line(Duration::from_secs(10));
        let bar = "█".repeat(10) + &"░".repeat(30);
        assert_eq!(line, format!("beamforming          {bar}  25 %  30s"));
        state.done = 1;
        assert!(state.line(Duration::from_secs(10)).ends_with("  0 %   3h"));
        state.done = 250;
        assert!(state.line(Duration::from_secs(100)).ends_with(" 25 %   5m"));
        state.done = 0;
        assert!(state.line(Duration::ZERO).ends_with("  0 %     "));
        state.done = 2000;
        assert!(state.line(Duration::ZERO).ends_with("100 %   0s"));
        assert_eq!(state.words(Duration::ZERO), "beamforming: 100 %, 0s left");
        state.steps = 0;
        assert_eq!(state.line(Duration::ZERO), "beamforming");
        assert_eq!(state.words(Duration::ZERO), "beamforming");
    }

    #[test]
    fn without_a_terminal_there_is_a_line_a_minute_and_for_each_step_of_many() {
        let progress = Progress::new("reading", 3);
        let mut state = progress.state.into_inner().unwrap();
        let begin = state.last_line.1;
        assert!(!state.line_is_due(begin + LINE / 2, true));
        state.message = "writing".into();
        assert!(!state.line_is_due(begin + LINE / 2, false));
        assert!(state.line_is_due(begin + LINE / 2, true));
        assert!(!state.line_is_due(begin + LINE, true));
        assert!(state.line_is_due(begin + LINE + LINE / 2, false));
        assert!(!state.line_is_due(begin + 2 * LINE, false));
    }

    #[test]
    fn the_bar_knows_its_state_and_is_drawn_once_a_period() {
        let progress = Progress::new("reading", 3);
        progress.set(1, 4);
        progress.set_message("writing".into());
        let mut state = progress.state.into_inner().unwrap();
        assert_eq!(
            (&state.message[..], state.done, state.steps),
            ("writing", 1, 4)
        );
        let begin = Instant::now();
        state.drawn = None;
        assert!(state.is_due(begin));
        assert!(!state.is_due(begin + PERIOD / 2));
        assert!(state.is_due(begin + PERIOD));
        assert!(!state.is_due(begin + PERIOD + PERIOD / 2));
    }
}
