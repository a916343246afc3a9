//! The live view against a server that decodes every byte: pictures arrive whole, and no server can hold a renderer up.

use std::io::{ErrorKind, Read};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use pdembree::film::{Channel, Image};
use pdembree::output::tev::{BadAddress, Viewer};

/// Longer than anything here may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(20);
/// What tev took in one packet when its buffer had a fixed size.
const OLD_LIMIT: usize = 1 << 20;

#[derive(Debug)]
struct Create {
    width: i32,
    height: i32,
    channels: Vec<String>,
}

#[derive(Debug)]
struct Update {
    channels: Vec<String>,
    /// x, y, width, height.
    tile: [i32; 4],
    /// Bits of the samples of each channel.
    samples: Vec<Vec<u32>>,
}

#[derive(Debug)]
enum Packet {
    Create(Create),
    Update(Update),
}

/// Takes a packet's fields from its front.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (field, rest) = self.0.split_first_chunk().expect("a packet that is long enough");
        self.0 = rest;
        *field
    }

    fn int(&mut self) -> i32 {
        i32::from_le_bytes(self.take())
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|&byte| byte == 0).expect("a text with its end");
        let text = std::str::from_utf8(&self.0[..end]).expect("UTF-8").to_owned();
        self.0 = &self.0[end + 1..];
        text
    }

    fn channels(&mut self) -> Vec<String> {
        (0..self.int()).map(|_| self.text()).collect()
    }
}

fn decode(packet: &[u8], name: &str) -> Packet {
    let mut fields = Fields(packet);
    assert_eq!(u32::from_le_bytes(fields.take()) as usize, packet.len());
    let [kind, grab_focus] = fields.take();
    assert_eq!(fields.text(), name);
    let decoded = match kind {
        4 => {
            assert_eq!(grab_focus, 1);
            let (width, height) = (fields.int(), fields.int());
            Packet::Create(Create { width, height, channels: fields.channels() })
        }
        6 => {
            assert_eq!(grab_focus, 0);
            Packet::Update(decode_update(&mut fields))
        }
        _ => panic!("packets of kind {kind} are not expected"),
    };
    assert!(fields.0.is_empty(), "{} bytes too many", fields.0.len());
    decoded
}

fn decode_update(fields: &mut Fields) -> Update {
    let channels = fields.channels();
    let tile: [i32; 4] = std::array::from_fn(|_| fields.int());
    let longs =
        |fields: &mut Fields| -> Vec<i64> { channels.iter().map(|_| i64::from_le_bytes(fields.take())).collect() };
    let (offsets, strides) = (longs(fields), longs(fields));
    let pixels = i64::from(tile[2]) * i64::from(tile[3]);
    assert_eq!(fields.0.len() as i64, 4 * pixels * channels.len() as i64, "{tile:?}");
    let data: Vec<u32> = (0..fields.0.len() / 4).map(|_| u32::from_le_bytes(fields.take())).collect();
    // As the protocol defines it, so that the test would follow another order of the samples.
    let sample = |c: usize, pixel: i64| data[usize::try_from(offsets[c] + pixel * strides[c]).expect("an index")];
    let samples = (0..channels.len()).map(|c| (0..pixels).map(|pixel| sample(c, pixel)).collect()).collect();
    Update { channels, tile, samples }
}

/// The next packet; none if the connection ends before it.
fn read(stream: &mut TcpStream, name: &str) -> Option<Packet> {
    let mut packet = vec![0; 4];
    match stream.read_exact(&mut packet) {
        Err(e) if e.kind() == ErrorKind::UnexpectedEof => return None,
        read => read.expect("bytes or an end"),
    }
    let length = u32::from_le_bytes(packet[..].try_into().expect("4 bytes")) as usize;
    assert!((6..OLD_LIMIT).contains(&length), "a packet of {length} bytes");
    packet.resize(length, 0);
    stream.read_exact(&mut packet[4..]).expect("the whole packet");
    Some(decode(&packet, name))
}

fn expect_creation(packet: Option<Packet>, image: &Image) {
    let Some(Packet::Create(create)) = packet else { panic!("{packet:?} where the picture should be created") };
    assert_eq!((create.width as u32, create.height as u32), (image.width, image.height));
    assert!(create.channels.iter().eq(image.channels.iter().map(|channel| &channel.name)), "{create:?}");
}

/// Asks until there is an answer, but not for ever.
fn until<T>(what: &str, mut ask: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        match ask() {
            Some(answer) => return answer,
            None => assert!(start.elapsed() < PATIENCE, "waited in vain for {what}"),
        }
        thread::sleep(Duration::from_millis(5));
    }
}

fn listen() -> (TcpListener, String) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = listener.local_addr().expect("bound").to_string();
    (listener, address)
}

/// A new server with the address of an old one.
fn listen_again(address: &str) -> TcpListener {
    until("the old address", || TcpListener::bind(address).ok())
}

fn accept(listener: &TcpListener) -> TcpStream {
    listener.set_nonblocking(true).expect("a listener that can be asked");
    let (stream, _) = until("a connection", || listener.accept().ok());
    stream.set_nonblocking(false).expect("a blocking stream");
    stream.set_read_timeout(Some(PATIENCE)).expect("a time-out");
    stream
}

/// What went wrong, as soon as the thread says so.
fn trouble_of(viewer: &Viewer) -> String {
    until("a trouble", || viewer.trouble())
}

/// One connection to a viewer that records what it is told.
struct Recorder {
    packets: Receiver<Packet>,
    thread: JoinHandle<()>,
}

impl Recorder {
    /// Accepts one connection and reads it to its end.
    fn start(listener: TcpListener, name: &'static str) -> Recorder {
        let (sender, packets) = channel();
        let thread = thread::spawn(move || {
            let mut stream = accept(&listener);
            while let Some(packet) = read(&mut stream, name) {
                if sender.send(packet).is_err() {
                    break;
                }
            }
        });
        Recorder { packets, thread }
    }

    fn next(&self) -> Packet {
        self.packets.recv_timeout(PATIENCE).expect("a packet")
    }

    fn expect_creation(&self, image: &Image) {
        expect_creation(Some(self.next()), image);
    }

    /// Updates that give every sample of `image` its bits, each once.
    fn expect_pixels(&self, image: &Image) {
        let mut seen = vec![false; image.pixels()];
        while seen.contains(&false) {
            let Packet::Update(update) = self.next() else { panic!("the picture was created twice") };
            assert!(update.channels.iter().eq(image.channels.iter().map(|channel| &channel.name)));
            let [left, top, width, height] = update.tile.map(|side| usize::try_from(side).expect("not negative"));
            assert!(left + width <= image.width as usize && top + height <= image.height as usize);
            for pixel in 0..width * height {
                let at = (top + pixel / width) * image.width as usize + left + pixel % width;
                assert!(!std::mem::replace(&mut seen[at], true), "pixel {at} came twice");
                for (channel, samples) in image.channels.iter().zip(&update.samples) {
                    assert_eq!(samples[pixel], channel.samples[at].to_bits(), "{} of pixel {at}", channel.name);
                }
            }
        }
    }

    fn expect_end(self) {
        let end = self.packets.recv_timeout(PATIENCE).map(|packet| format!("{packet:?}"));
        assert_eq!(end, Err(RecvTimeoutError::Disconnected));
        self.thread.join().expect("a connection that ends between packets");
    }
}

/// A picture whose samples all differ, also from those of another `seed`.
fn picture(width: u32, height: u32, channels: &[&str], seed: u32) -> Image {
    let pixels = width * height;
    let channel = |(c, name): (u32, &&str)| Channel {
        name: (*name).to_owned(),
        samples: (0..pixels).map(|i| (f64::from(c * pixels + i) * 0.1 - f64::from(seed)) as f32).collect(),
    };
    Image { width, height, channels: (0..).zip(channels).map(channel).collect() }
}

/// More than the buffers of both ends hold: 32 MB.
fn huge() -> Image {
    let channel = |name: &str| Channel { name: name.to_owned(), samples: vec![0.5; 2000 * 2000] };
    Image { width: 2000, height: 2000, channels: ["Y", "Z"].map(channel).into() }
}

#[test]
fn a_picture_arrives_bit_for_bit_in_packets_that_every_viewer_takes() {
    // Many rows a packet, one pixel, less than one row a packet, two rows.
    for (width, height) in [(301, 203), (1, 1), (30_000, 3), (13_000, 5)] {
        let mut image = picture(width, height, &["R", "G", "B", "caustic.R", "Tiefe ü"], 1);
        let odd = [f32::NAN, f32::from_bits(0xffc1_2345), f32::INFINITY, f32::NEG_INFINITY, -0.0, 1e-45];
        for (channel, sample) in image.channels.iter_mut().zip(odd) {
            *channel.samples.last_mut().expect("a pixel") = sample;
        }
        let (listener, address) = listen();
        let recorder = Recorder::start(listener, "ring 光");
        let viewer = Viewer::open(&address, "ring 光").expect("an address");
        viewer.show(image.clone());
        recorder.expect_creation(&image);
        recorder.expect_pixels(&image);
        assert_eq!(viewer.close(), None);
        recorder.expect_end();
    }
}

#[test]
fn a_changed_picture_is_an_update_and_a_changed_layout_a_creation() {
    let (listener, address) = listen();
    let recorder = Recorder::start(listener, "a");
    let viewer = Viewer::open(&address, "a").expect("an address");
    let rgb: &[&str] = &["R", "G", "B"];
    let layouts = [(40, 30, rgb), (30, 40, rgb), (30, 40, &["R", "G", "Z"])];
    for (width, height, channels) in layouts {
        for seed in 0..3 {
            let image = picture(width, height, channels, seed);
            viewer.show(image.clone());
            if seed == 0 {
                recorder.expect_creation(&image);
            }
            recorder.expect_pixels(&image);
        }
    }
    assert_eq!(viewer.trouble(), None);
    drop(viewer);
    recorder.expect_end();
}

#[test]
fn the_last_picture_is_sent_before_the_viewer_is_dropped() {
    let (listener, address) = listen();
    let recorder = Recorder::start(listener, "a");
    let image = picture(100, 80, &["R", "G", "B"], 0);
    let viewer = Viewer::open(&address, "a").expect("an address");
    viewer.show(image.clone());
    drop(viewer);
    recorder.expect_creation(&image);
    recorder.expect_pixels(&image);
    recorder.expect_end();
}

#[test]
fn of_the_pictures_that_wait_only_the_newest_is_sent() {
    let (listener, address) = listen();
    let viewer = Viewer::open(&address, "a").expect("an address");
    let first = huge();
    viewer.show(first.clone());
    let mut stream = accept(&listener);
    expect_creation(read(&mut stream, "a"), &first);
    // The first picture is on its way and cannot arrive, as nobody reads: these have to wait for it.
    for seed in 1..=5 {
        viewer.show(picture(30, 20, &["Y"], seed));
    }
    let mut pixels = 0;
    while pixels < 2000 * 2000 {
        let Some(Packet::Update(update)) = read(&mut stream, "a") else { panic!("the first picture is not whole") };
        pixels += update.tile[2] * update.tile[3];
    }
    let newest = picture(30, 20, &["Y"], 5);
    expect_creation(read(&mut stream, "a"), &newest);
    let Some(Packet::Update(update)) = read(&mut stream, "a") else { panic!("no pixels") };
    let bits: Vec<u32> = newest.channels[0].samples.iter().map(|sample| sample.to_bits()).collect();
    assert_eq!(update.samples, [bits]);
    assert_eq!(viewer.close(), None);
    assert!(read(&mut stream, "a").is_none());
}

#[test]
fn a_viewer_that_never_reads_holds_nobody_up() {
    let (listener, address) = listen();
    let viewer = Viewer::open(&address, "a").expect("an address");
    viewer.show(huge());
    let mut stream = accept(&listener);
    for seed in 0..5 {
        let image = picture(500, 400, &["R", "G", "B"], seed);
        let start = Instant::now();
        viewer.show(image);
        assert!(start.elapsed() < Duration::from_millis(500), "show took {:?}", start.elapsed());
    }
    let start = Instant::now();
    let trouble = viewer.close().expect("the picture cannot have arrived");
    assert!(start.elapsed() < Duration::from_secs(3), "the end took {:?}", start.elapsed());
    assert!(trouble.contains("given up") || trouble.contains("took no data"), "{trouble}");
    // The thread does not stay behind either: its connection ends, in the middle of the picture.
    let received = std::io::copy(&mut stream, &mut std::io::sink()).expect("an end");
    assert!(received < 32_000_000, "{received} bytes");
}

#[test]
fn a_viewer_that_stops_reading_is_reported() {
    let (listener, address) = listen();
    let viewer = Viewer::open(&address, "a").expect("an address");
    viewer.show(huge());
    let _unread = accept(&listener);
    let trouble = trouble_of(&viewer);
    assert!(trouble.contains(&address) && trouble.contains("took no data"), "{trouble}");
}

#[test]
fn without_a_viewer_everything_works_and_the_trouble_is_told() {
    // No port that a system gives to whoever asks for one, as a test beside this one may.
    let address = "127.0.0.1:1";
    let viewer = Viewer::open(address, "a").expect("an address");
    viewer.show(picture(8, 8, &["Y"], 0));
    assert!(trouble_of(&viewer).contains(address));
    viewer.show(picture(8, 8, &["Y"], 1));
    let start = Instant::now();
    let trouble = viewer.close().expect("nobody listens");
    assert!(trouble.contains(address) && trouble.contains("cannot connect"), "{trouble}");
    assert!(start.elapsed() < Duration::from_secs(3), "the end took {:?}", start.elapsed());
    // Nothing shown, nothing wrong.
    assert_eq!(Viewer::open(address, "a").expect("an address").close(), None);
}

#[test]
fn a_viewer_that_was_started_again_between_pictures_misses_none() {
    let (listener, address) = listen();
    let viewer = Viewer::open(&address, "a").expect("an address");
    let image = picture(20, 10, &["Y"], 0);
    viewer.show(image.clone());
    let mut stream = accept(&listener);
    expect_creation(read(&mut stream, "a"), &image);
    assert!(matches!(read(&mut stream, "a"), Some(Packet::Update(_))));
    drop((stream, listener));
    let recorder = Recorder::start(listen_again(&address), "a");
    viewer.show(image.clone());
    recorder.expect_creation(&image);
    recorder.expect_pixels(&image);
    assert_eq!(viewer.close(), None);
}

#[test]
fn a_viewer_that_died_within_a_picture_gets_the_next_one_when_it_is_back() {
    let (listener, address) = listen();
    let viewer = Viewer::open(&address, "a").expect("an address");
    viewer.show(huge());
    let mut stream = accept(&listener);
    assert!(matches!(read(&mut stream, "a"), Some(Packet::Create(_))));
    let death = Instant::now();
    drop((stream, listener));
    let trouble = trouble_of(&viewer);
    assert!(trouble.contains(&address) && trouble.contains("broke"), "{trouble}");
    let recorder = Recorder::start(listen_again(&address), "a");
    let image = picture(20, 10, &["Y"], 0);
    viewer.show(image.clone());
    recorder.expect_creation(&image);
    assert!(death.elapsed() > Duration::from_secs(2), "it is not asked again and again");
    recorder.expect_pixels(&image);
    assert_eq!(viewer.close(), Some(trouble), "the first trouble is kept");
    recorder.expect_end();
}

#[test]
fn pictures_that_are_none_are_reported_and_not_sent() {
    let whole = picture(4, 4, &["R", "G", "B"], 0);
    let mut short = whole.clone();
    short.channels[1].samples.pop();
    let unfit = [
        (short, "channel G"),
        (Image { width: 0, height: 4, channels: whole.channels.clone() }, "no pixels"),
        (Image { channels: Vec::new(), ..whole.clone() }, "no pixels"),
    ];
    for (image, reason) in unfit {
        let (listener, address) = listen();
        let recorder = Recorder::start(listener, "a");
        let viewer = Viewer::open(&address, "a").expect("an address");
        viewer.show(image);
        let trouble = trouble_of(&viewer);
        assert!(trouble.contains(reason), "{trouble}");
        // It does not disturb those that come later.
        viewer.show(whole.clone());
        recorder.expect_creation(&whole);
        recorder.expect_pixels(&whole);
    }
}

#[test]
fn a_zero_byte_in_a_name_shifts_nothing() {
    let (listener, address) = listen();
    let recorder = Recorder::start(listener, "ab");
    let viewer = Viewer::open(&address, "a\0b").expect("an address");
    viewer.show(picture(3, 2, &["R\0ed"], 0));
    let seen = picture(3, 2, &["Red"], 0);
    recorder.expect_creation(&seen);
    recorder.expect_pixels(&seen);
}

#[test]
fn malformed_addresses_are_refused_with_what_to_write() {
    let refused = |address: &str| match Viewer::open(address, "a") {
        Ok(_) => panic!("`{address}` was taken"),
        Err(e) => {
            let text = e.to_string();
            assert!(text.contains(&format!("`{address}`")) && text.contains("write "), "{text}");
            e
        }
    };
    for address in ["", ":1", ":"] {
        assert!(matches!(refused(address), BadAddress::NoHost { .. }), "{address}");
    }
    for address in ["host:", "host:99999", "host:65536", "host:0", "host:-1", "host:+5", "host: 5", "[::1]:", "[::1]:x"]
    {
        assert!(matches!(refused(address), BadAddress::Port { .. }), "{address}");
    }
    for address in ["a b", " host:1", "host/path", "user@host:1", "host]:1"] {
        assert!(matches!(refused(address), BadAddress::Host { .. }), "{address}");
    }
    for address in ["::1", "a:1:2", "[::1", "[host]:1", "[]:1", "[::1]1", "[::1]:1:2"] {
        assert!(matches!(refused(address), BadAddress::Colons { .. }), "{address}");
    }
    for address in
        ["localhost", "render-7.example:14159", "127.0.0.1:65535", "[::1]", "[fe80::1%eth0]:14158", "bücher_1"]
    {
        assert!(Viewer::open(address, "a").is_ok(), "{address}");
    }
}
