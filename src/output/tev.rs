//! Live view: pictures sent over TCP to a viewer that speaks tev's protocol, while the rendering goes on.
//!
//! A renderer must not wait for its viewer, nor fail with it: one thread of each [`Viewer`] holds the connection, and
//! of the pictures that wait for it only the newest is kept.

mod address;
mod packet;

use std::io::{self, ErrorKind, Write};
use std::net::TcpStream;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

pub use address::{BadAddress, DEFAULT_PORT};

use crate::film::Image;
use address::Address;
use packet::{Layout, packets};

/// For each address that a host's name stands for.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(1);
/// A viewer that takes not one byte for so long counts as lost.
const WRITE_TIMEOUT: Duration = Duration::from_secs(2);
/// From a failure to the next attempt.
const RETRY_PAUSE: Duration = Duration::from_secs(3);
/// How long the end of a [`Viewer`] waits for its last picture.
const FAREWELL: Duration = Duration::from_secs(1);

/// A window of a running viewer that shows the pictures of one rendering.
#[derive(Debug)]
pub struct Viewer {
    shared: Arc<Shared>,
}

impl Viewer {
    /// A viewer at `address`: `host` or `host:port` (port [`DEFAULT_PORT`] if there is none), an IPv6 address in
    /// brackets. It lists the pictures under `name`. The first picture makes the connection, in the background; a
    /// viewer that is not there is no error, see [`Viewer::trouble`].
    ///
    /// # Errors
    /// `address` is not of that form.
    pub fn open(address: &str, name: &str) -> Result<Viewer, BadAddress> {
        let address = Address::parse(address)?;
        let shared = Arc::new(Shared::default());
        let now = Instant::now();
        let sender = Sender { shared: shared.clone(), address, name: name.to_owned(), link: None, retry_at: now };
        if let Err(e) = thread::Builder::new().name("live view".to_owned()).spawn(move || sender.run()) {
            shared.note(format!("live view: no thread for it: {e}"));
            shared.enter(Phase::Ended);
        }
        Ok(Viewer { shared })
    }

    /// Shows the picture as it is now. Returns at once: while the viewer is busy with an earlier picture, this one
    /// waits and replaces the one that waited before.
    pub fn show(&self, image: Image) {
        let replaced = self.shared.lock().waiting.replace(image);
        self.shared.changed.notify_all();
        // Freed only now: that takes time for a large picture, and the thread need not wait for the lock meanwhile.
        drop(replaced);
    }

    /// The first thing that went wrong so far, if anything did, also if it went well afterwards. A picture that is not
    /// yet sent may still fail: after the last one, [`Viewer::close`] knows more.
    pub fn trouble(&self) -> Option<String> {
        self.shared.lock().trouble.clone()
    }

    /// Ends the live view as dropping it does, and says what went wrong.
    pub fn close(self) -> Option<String> {
        self.finish();
        self.trouble()
    }

    /// Waits for the last picture, but not for long.
    fn finish(&self) {
        self.shared.enter(Phase::Closing);
        let running = |state: &mut State| state.phase < Phase::Abandoned;
        let waited = self.shared.changed.wait_timeout_while(self.shared.lock(), FAREWELL, running);
        let (mut state, timeout) = waited.unwrap_or_else(PoisonError::into_inner);
        if timeout.timed_out() {
            state.phase = Phase::Abandoned;
            let late = || format!("live view: the last picture was given up after {} s", FAREWELL.as_secs());
            state.trouble.get_or_insert_with(late);
        }
    }
}

/// The last waiting picture is still sent, if the viewer takes it within a second.
impl Drop for Viewer {
    fn drop(&mut self) {
        self.finish();
    }
}

/// How far the life of a [`Viewer`] has come; it only goes forward.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
enum Phase {
    #[default]
    Open,
    /// No more pictures will come; the one that waits is to be sent.
    Closing,
    /// Nobody waits any more for what is being sent.
    Abandoned,
    /// The thread is gone.
    Ended,
}

#[derive(Debug, Default)]
struct State {
    waiting: Option<Image>,
    phase: Phase,
    trouble: Option<String>,
}

/// What a [`Viewer`] and its thread know of each other.
#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        // No invariant spans the fields: a panic of the other thread leaves nothing half done.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn enter(&self, phase: Phase) {
        let mut state = self.lock();
        state.phase = state.phase.max(phase);
        self.changed.notify_all();
    }

    fn abandoned(&self) -> bool {
        self.lock().phase >= Phase::Abandoned
    }

    fn note(&self, trouble: String) {
        self.lock().trouble.get_or_insert(trouble);
    }

    /// Waits for a picture, and until `retry_at` if more can come meanwhile; none if there will be no more.
    fn next(&self, retry_at: Instant) -> Option<Image> {
        let mut state = self.lock();
        loop {
            let pause = retry_at.saturating_duration_since(Instant::now());
            state = match state.phase {
                Phase::Open if state.waiting.is_none() => {
                    self.changed.wait(state).unwrap_or_else(PoisonError::into_inner)
                }
                Phase::Open if !pause.is_zero() => {
                    self.changed.wait_timeout(state, pause).unwrap_or_else(PoisonError::into_inner).0
                }
                Phase::Open | Phase::Closing => return state.waiting.take(),
                Phase::Abandoned | Phase::Ended => return None,
            }
        }
    }
}

/// The thread's side: sends one picture after the other.
struct Sender {
    shared: Arc<Shared>,
    address: Address,
    name: String,
    link: Option<Link>,
    /// No attempt before.
    retry_at: Instant,
}

impl Sender {
    fn run(mut self) {
        while let Some(image) = self.shared.next(self.retry_at) {
            let sent = match Layout::of(&image) {
                Ok(layout) => self.send(&image, layout),
                Err(reason) => Err(format!("a picture was not shown: {reason}")),
            };
            if let Err(trouble) = sent {
                self.shared.note(format!("live view at {}: {trouble}", self.address));
            }
        }
        self.shared.enter(Phase::Ended);
    }

    /// Sends a picture over the connection, or over a new one if there is none. After an error there is none.
    fn send(&mut self, image: &Image, layout: Layout) -> Result<(), String> {
        let link = match self.link.take().filter(Link::alive) {
            Some(link) => Ok(link),
            None => {
                Link::connect(&self.address).map_err(|e| format!("cannot connect: {e}; does the viewer run there?"))
            }
        };
        let sent = link.and_then(|link| link.send(&self.name, image, layout, &self.shared).map_err(|e| broken(&e)));
        if sent.is_err() {
            self.retry_at = Instant::now() + RETRY_PAUSE;
        }
        self.link = Some(sent?);
        Ok(())
    }
}

/// What a failed write means to the user.
fn broken(error: &io::Error) -> String {
    match error.kind() {
        // Systems differ in how they call a write that timed out.
        ErrorKind::WouldBlock | ErrorKind::TimedOut => {
            format!("the viewer took no data for {} s; does it hang?", WRITE_TIMEOUT.as_secs())
        }
        _ => format!("the connection broke: {error}; was the viewer closed?"),
    }
}

/// A connection and what the viewer was told over it.
struct Link {
    stream: TcpStream,
    /// Of the picture that the viewer holds; none before the first.
    layout: Option<Layout>,
}

impl Link {
    fn connect(address: &Address) -> io::Result<Link> {
        let stream = address.connect(CONNECT_TIMEOUT)?;
        stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
        Ok(Link { stream, layout: None })
    }

    /// Whether the viewer still holds its end. Without asking, the first picture after its death would be lost, as the
    /// system takes the bytes before it learns that nobody wants them.
    fn alive(&self) -> bool {
        let peeked = self.stream.set_nonblocking(true).and_then(|()| self.stream.peek(&mut [0]));
        let open = match peeked {
            Ok(bytes) => bytes > 0,
            Err(e) => e.kind() == ErrorKind::WouldBlock,
        };
        open && self.stream.set_nonblocking(false).is_ok()
    }

    /// Sends a picture, and gives the connection back if it still works.
    fn send(mut self, name: &str, image: &Image, layout: Layout, shared: &Shared) -> io::Result<Link> {
        let create = self.layout.as_ref() != Some(&layout);
        for packet in packets(name, image, &layout, create) {
            self.write(&packet, shared)?;
        }
        self.layout = Some(layout);
        Ok(self)
    }

    /// Writes all of `packet`, unless the owner of the live view is gone.
    fn write(&mut self, mut packet: &[u8], shared: &Shared) -> io::Result<()> {
        while !packet.is_empty() {
            if shared.abandoned() {
                return Err(ErrorKind::TimedOut.into());
            }
            match self.stream.write(packet) {
                Ok(0) => return Err(ErrorKind::WriteZero.into()),
                Ok(bytes) => packet = &packet[bytes..],
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(e) => return Err(e),
            }
        }
        Ok(())
    }
}
