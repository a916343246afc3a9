//! A render cut into tasks: ranges of passes by tiles of the picture.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::error::SubmitError;

/// Names of all parts fit on the command line of `merge`, also where folders' names are long.
const MOST_TASKS: u64 = 4096;

/// A render that others shall do. All paths are absolute, and mean the same on every machine that takes a task.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Job {
    /// The renderer.
    pub program: PathBuf,
    pub scene: PathBuf,
    /// More arguments of every render task, as they are; threads are not among them. Paths are absolute here too:
    /// engines choose the folder that a task starts in.
    pub settings: Vec<String>,
    /// More arguments of the merge, as they are.
    pub merge_settings: Vec<String>,
    /// Passes of the picture, under these settings.
    pub passes: u32,
    /// Ranges that the passes are split into.
    pub parts: u32,
    /// Tiles that the picture is split into, in each range.
    pub tiles: u32,
    /// The picture.
    pub output: PathBuf,
    /// Where parts, logs and job files go; it belongs to this job alone.
    pub folder: PathBuf,
    /// Threads of a task; `None` leaves it to the engine.
    pub threads: Option<u32>,
}

/// What one process renders.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Task {
    pub passes: Range<u32>,
    /// The tile's number, and how many there are; `None` when the picture is not split.
    pub tile: Option<(u32, u32)>,
    /// The file it writes.
    pub part: PathBuf,
}

impl Job {
    /// All tasks, tiles of a range side by side. Sizes of ranges differ by one pass at most.
    pub fn tasks(&self) -> Vec<Task> {
        let tiles = |passes: Range<u32>| (0..self.tiles).map(move |tile| self.task(passes.clone(), tile));
        self.ranges().flat_map(tiles).collect()
    }

    /// The ranges of passes, in order.
    pub(super) fn ranges(&self) -> impl Iterator<Item = Range<u32>> {
        (0..self.parts).map(|part| self.start_of(part)..self.start_of(part + 1))
    }

    fn start_of(&self, part: u32) -> u32 {
        // At most `passes`, since `part` is at most `parts`.
        (u64::from(part) * u64::from(self.passes) / u64::from(self.parts)) as u32
    }

    fn task(&self, passes: Range<u32>, tile: u32) -> Task {
        let name = self.part_name(&passes.start.to_string(), &passes.end.to_string(), &tile.to_string());
        Task { part: self.folder.join(name), passes, tile: self.is_tiled().then_some((tile, self.tiles)) }
    }

    /// Named by what it holds, so that a job with another number of parts does not take it for one of its own.
    pub(super) fn part_name(&self, start: &str, end: &str, tile: &str) -> String {
        let tile = if self.is_tiled() { format!("_tile_{tile}_of_{}", self.tiles) } else { String::new() };
        format!("passes_{start}_to_{end}{tile}.pdpart")
    }

    pub(super) fn is_tiled(&self) -> bool {
        self.tiles > 1
    }

    /// Arguments that all render tasks have in common.
    pub(super) fn render_arguments(&self) -> Vec<String> {
        let mut arguments = vec!["render".to_owned(), text(&self.scene)];
        arguments.extend(self.settings.iter().cloned());
        arguments
    }

    /// Arguments of one render task, threads apart.
    pub(super) fn task_arguments(&self, task: &Task) -> Vec<String> {
        let mut arguments = self.render_arguments();
        arguments.extend(["--pass-range".to_owned(), format!("{}..{}", task.passes.start, task.passes.end)]);
        if let Some((tile, tiles)) = task.tile {
            arguments.extend(["--tile".to_owned(), format!("{tile}/{tiles}")]);
        }
        arguments.extend(["-o".to_owned(), text(&task.part)]);
        arguments
    }

    /// Arguments of the merge.
    pub(super) fn merge_arguments(&self) -> Vec<String> {
        let mut arguments = vec!["merge".to_owned()];
        arguments.extend(self.tasks().iter().map(|task| text(&task.part)));
        arguments.extend(self.merge_settings.iter().cloned());
        arguments.extend(["-o".to_owned(), text(&self.output)]);
        arguments
    }

    /// The scene's name as all engines take it.
    pub(super) fn name(&self) -> String {
        let stem = self.scene.file_stem().unwrap_or_default().to_string_lossy();
        stem.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' }).take(40).collect()
    }

    /// Checks what all engines need, and makes the folder.
    pub(super) fn prepare(&self) -> Result<(), SubmitError> {
        self.check()?;
        std::fs::create_dir_all(&self.folder)
            .map_err(|source| SubmitError::Folder { folder: self.folder.clone(), source })
    }

    /// Checks the numbers, the paths and the settings, without looking at the disk.
    ///
    /// # Errors
    /// The first thing that no engine could take.
    pub fn check(&self) -> Result<(), SubmitError> {
        self.check_numbers()?;
        for path in [&self.program, &self.scene, &self.output, &self.folder] {
            check_path(path)?;
        }
        self.settings.iter().chain(&self.merge_settings).try_for_each(|setting| check_text(setting))
    }

    fn check_numbers(&self) -> Result<(), SubmitError> {
        let Job { passes, parts, tiles, .. } = *self;
        let threads = self.threads.unwrap_or(1);
        let counts = [("passes", passes), ("parts", parts), ("tiles", tiles), ("threads", threads)];
        if let Some((what, _)) = counts.into_iter().find(|&(_, count)| count == 0) {
            return Err(SubmitError::Zero { what });
        }
        if parts > passes {
            return Err(SubmitError::MorePartsThanPasses { parts, passes });
        }
        let tasks = u64::from(parts) * u64::from(tiles);
        if tasks > MOST_TASKS {
            return Err(SubmitError::TooManyTasks { tasks, most: MOST_TASKS });
        }
        Ok(())
    }
}

fn check_path(path: &Path) -> Result<(), SubmitError> {
    if !path.is_absolute() {
        return Err(SubmitError::NotAbsolute { path: path.to_owned() });
    }
    check_text(path.to_str().ok_or_else(|| SubmitError::NotUnicode { path: path.to_owned() })?)
}

fn check_text(text: &str) -> Result<(), SubmitError> {
    match text.contains(char::is_control) {
        true => Err(SubmitError::ControlCharacter { text: text.to_owned() }),
        false => Ok(()),
    }
}

/// A path as it stands in job files; nothing is lost, since [`Job::check`] takes Unicode only.
pub(super) fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

#[cfg(test)]
pub(super) mod tests {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;

    use super::*;

    /// A job with everything that is hard to quote.
    pub fn awkward() -> Job {
        Job {
            program: "/opt/a b/pdembree".into(),
            scene: "/scenes/it's \"Größe\" $HOME `x` %a.toml".into(),
            settings: ["--seed", "3", "-D", "a='b c'\\"].map(str::to_owned).into(),
            merge_settings: vec!["--no-timestamps".to_owned()],
            passes: 10,
            parts: 4,
            tiles: 2,
            output: "/out/o !.exr".into(),
            folder: "/out/p %j".into(),
            threads: Some(2),
        }
    }

    fn split(passes: u32, parts: u32) -> Vec<Range<u32>> {
        Job { passes, parts, tiles: 1, ..awkward() }.tasks().into_iter().map(|task| task.passes).collect()
    }

    #[test]
    fn passes_are_split_evenly() {
        assert_eq!(split(10, 4), [0..2, 2..5, 5..7, 7..10]);
        assert_eq!(split(3, 3), [0..1, 1..2, 2..3]);
        assert_eq!(split(7, 1), vec![0..7]);
        assert_eq!(split(u32::MAX, 2), [0..2147483647, 2147483647..u32::MAX]);
    }

    /// Every pass in exactly one range, none empty, sizes alike.
    #[test]
    fn ranges_cover_the_passes() {
        for passes in 1..40 {
            for parts in 1..=passes {
                let ranges = split(passes, parts);
                assert_eq!((ranges.len() as u32, ranges[0].start), (parts, 0));
                assert_eq!(ranges.last().map(|range| range.end), Some(passes));
                assert!(ranges.windows(2).all(|pair| pair[0].end == pair[1].start));
                let sizes = || ranges.iter().map(ExactSizeIterator::len);
                assert!(sizes().min() >= Some(1) && sizes().max() <= sizes().min().map(|least| least + 1));
            }
        }
    }

    #[test]
    fn every_tile_of_a_range_is_a_task() {
        let tasks = awkward().tasks();
        assert_eq!(tasks.len(), 8);
        let third =
            Task { passes: 2..5, tile: Some((1, 2)), part: "/out/p %j/passes_2_to_5_tile_1_of_2.pdpart".into() };
        assert_eq!(tasks[3], third);
        let whole = Job { tiles: 1, ..awkward() }.tasks();
        assert_eq!(whole[1].tile, None);
        assert_eq!(whole[1].part, Path::new("/out/p %j/passes_2_to_5.pdpart"));
    }

    #[test]
    fn arguments_are_those_of_the_program() {
        let job = awkward();
        let arguments = job.task_arguments(&job.tasks()[3]);
        let expected = "--seed|3|-D|a='b c'\\|--pass-range|2..5|--tile|1/2|-o|";
        assert!(arguments.join("|").contains(expected), "{arguments:?}");
        let merge = job.merge_arguments();
        assert_eq!((merge.len(), merge[0].as_str()), (1 + 8 + 1 + 2, "merge"));
        assert_eq!(merge[9..], ["--no-timestamps", "-o", "/out/o !.exr"]);
    }

    #[test]
    fn names_are_plain() {
        assert_eq!(awkward().name(), "it_s__Gr__e___HOME__x___a");
    }

    #[test]
    fn impossible_numbers_are_refused() {
        let message = |job: Job| job.check().expect_err("refused").to_string();
        assert_eq!(message(Job { passes: 0, ..awkward() }), "0 passes: there must be at least one");
        assert_eq!(message(Job { parts: 0, ..awkward() }), "0 parts: there must be at least one");
        assert_eq!(message(Job { tiles: 0, ..awkward() }), "0 tiles: there must be at least one");
        assert_eq!(message(Job { threads: Some(0), ..awkward() }), "0 threads: there must be at least one");
        assert!(message(Job { parts: 11, ..awkward() }).ends_with("ask for 10 parts at most"));
        let many = Job { passes: u32::MAX, parts: u32::MAX, tiles: u32::MAX, ..awkward() };
        assert!(matches!(many.check(), Err(SubmitError::TooManyTasks { .. })));
        assert!(awkward().check().is_ok());
    }

    #[test]
    fn paths_that_job_files_cannot_hold_are_refused() {
        let with = |scene: &OsStr| Job { scene: scene.into(), ..awkward() }.check();
        assert!(matches!(with("a.toml".as_ref()), Err(SubmitError::NotAbsolute { .. })));
        assert!(matches!(with("/a\nb.toml".as_ref()), Err(SubmitError::ControlCharacter { .. })));
        assert!(matches!(with(OsStr::from_bytes(b"/\xff.toml")), Err(SubmitError::NotUnicode { .. })));
        let setting = Job { settings: vec!["a\0".to_owned()], ..awkward() };
        assert!(matches!(setting.check(), Err(SubmitError::ControlCharacter { .. })));
    }
}
