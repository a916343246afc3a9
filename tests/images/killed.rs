//! A render that is killed again and again ends at the same file, and never loses what it had saved.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use pdembree::film::Exposure;
use pdembree::output::part;
use pdembree::sampling::{Purpose, Stream};

use crate::support::data::root;

const KILLS: u32 = 200;
/// About a third of a second; saved so often that some kills hit the saving.
const WORDS: &str = "--passes=4 --spp=2 --photons=5000 -Dcamera.resolution=[64,48] -Dcamera.width=0.6 --no-timestamps -q \
                     --checkpoint=c.pdpart --every=0.01s --resume -o out.exr";

fn command(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pdembree"));
    command.current_dir(folder).arg("render").arg(root().join("scenes/tests/ball_lens.toml"));
    command.args(WORDS.split_whitespace()).stdout(Stdio::null()).stderr(Stdio::null());
    command
}

/// Passes and units that the checkpoint holds; none where there is none. A file that is there is whole.
fn saved(folder: &Path) -> (u32, usize) {
    let path = folder.join("c.pdpart");
    if !path.exists() {
        return (0, 0);
    }
    let film = part::read(&path).expect("whole at any moment").film;
    (film.passes(), film.added(Exposure::Eye).len())
}

#[test]
fn killed_at_200_random_moments_it_ends_at_the_same_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let (here, picture) = (folder.path(), folder.path().join("out.exr"));
    let start = Instant::now();
    assert!(command(here).status().expect("it starts").success());
    let whole = start.elapsed();
    let expected = std::fs::read(&picture).expect("a picture");
    let mut moments = Stream::new(1, Purpose::Test, 0, 0);
    let (mut kills, mut renders, mut in_the_middle) = (0, 0, 0);
    std::fs::remove_file(here.join("c.pdpart")).expect("there");
    let mut before = (0, 0);
    while kills < KILLS {
        let mut child = command(here).spawn().expect("it starts");
        std::thread::sleep(whole.mul_f64(moments.uniform()));
        // Fails where it has ended already.
        let _ = child.kill();
        let status = child.wait().expect("it ends");
        let now = saved(here);
        assert!(now >= before, "{before:?} was saved, now {now:?}");
        if status.success() {
            assert_eq!(std::fs::read(&picture).expect("a picture"), expected, "after {kills} kills");
            std::fs::remove_file(here.join("c.pdpart")).expect("there");
            (renders, before) = (renders + 1, (0, 0));
        } else {
            assert!(status.code().is_none(), "it failed by itself: {status}");
            (kills, in_the_middle, before) = (kills + 1, in_the_middle + u32::from(now.1 > 0), now);
        }
        assert!(start.elapsed() < Duration::from_secs(600), "{kills} kills only");
    }
    println!("{kills} kills, {in_the_middle} with a pass half saved, {renders} renders finished in between");
    assert!(renders > 0 && in_the_middle > 0);
    assert!(command(here).status().expect("it starts").success());
    assert_eq!(std::fs::read(&picture).expect("a picture"), expected);
}
