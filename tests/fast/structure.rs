//! The house's rules, read from our own source text.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::support::data::root;
use crate::support::source::{Line, files, lines};

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Every Rust file of `src/` with its path relative to it.
fn sources() -> Vec<(String, Vec<Line>)> {
    let src = root().join("src");
    let name = |path: &Path| path.strip_prefix(&src).expect("below src").to_string_lossy().into_owned();
    files(&src, "rs").iter().map(|path| (name(path), lines(&read(path)))).collect()
}

fn report(broken: &[String]) {
    assert!(broken.is_empty(), "\n{}", broken.join("\n"));
}

/// The modules of lib.rs in their order.
fn module_order() -> Vec<String> {
    let text = read(&root().join("src/lib.rs"));
    let module = |l: Line| Some(l.code.trim().strip_prefix("pub mod ")?.strip_suffix(';')?.to_string());
    let order: Vec<String> = lines(&text).into_iter().filter_map(module).collect();
    assert!(order.len() >= 9, "lib.rs: {order:?}");
    order
}

/// First path segments after `crate::` in `code`, braces included: `crate::{a::B, c::{D, E}}` gives a and c.
fn crate_paths(code: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        if code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == '$') {
            continue;
        }
        let rest = &code[at + "crate::".len()..];
        match rest.strip_prefix('{') {
            None => found.push(identifier(rest)),
            Some(group) => {
                let (mut depth, mut start) = (1, 0);
                for (i, c) in group.char_indices() {
                    match c {
                        '{' => depth += 1,
                        '}' => depth -= 1,
                        _ => {}
                    }
                    if depth == 0 || depth == 1 && c == ',' {
                        found.push(identifier(group[start..i].trim_start()));
                        start = i + 1;
                    }
                    if depth == 0 {
                        break;
                    }
                }
            }
        }
    }
    found
}

fn identifier(text: &str) -> String {
    text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

#[test]
fn crate_paths_are_found_in_every_form() {
    let code = "use crate::math::Vec3;\nuse crate::{scene::{Scene, Object}, light::Aim};\nlet x = crate::film::Film; nocrate::no();";
    assert_eq!(crate_paths(code), ["math", "scene", "light", "film"]);
}

#[test]
fn a_module_imports_only_modules_above_it() {
    let order = module_order();
    let rank = |name: &str| order.iter().position(|m| m == name);
    let mut broken = Vec::new();
    for (file, lines) in sources() {
        let module = file.split(['/', '.']).next().expect("a first segment");
        let Some(own) = rank(module) else {
            assert!(["lib", "main", "cli"].contains(&module), "src/{file} belongs to no module of lib.rs");
            continue;
        };
        let code: String = lines.iter().map(|l| format!("{}\n", l.code)).collect();
        for used in crate_paths(&code) {
            match rank(&used) {
                Some(r) if r <= own => {}
                Some(_) => {
                    broken.push(format!("src/{file}: `{module}` imports `{used}`, which stands below it in lib.rs"))
                }
                None => broken.push(format!("src/{file}: `crate::{used}` is no module of lib.rs")),
            }
        }
    }
    report(&broken);
}

/// Tags like `Igehy99` or `Frisvad-slides`: a capital, letters, then digits or a hyphenated word.
fn is_tag(word: &str) -> bool {
    let stem = word.trim_end_matches(|c: char| c.is_ascii_digit());
    let letters = |s: &str| !s.is_empty() && s.chars().all(char::is_alphabetic);
    word.starts_with(|c: char| c.is_ascii_uppercase())
        && match stem.split_once('-') {
            Some((name, kind)) => stem == word && letters(name) && letters(kind),
            None => letters(stem) && word.len() - stem.len() >= 2,
        }
}

/// Tags cited in square brackets.
fn cited(text: &str) -> Vec<String> {
    let inside = |(at, _): (usize, &str)| text[at + 1..].split(']').next().map(str::to_string);
    let cites = text.match_indices('[').filter_map(inside);
    cites.filter_map(|c| c.split([' ', ',']).next().filter(|w| is_tag(w)).map(str::to_string)).collect()
}

#[test]
fn tags_are_told_from_links() {
    assert_eq!(
        cited("as [Igehy99 (15)] and [Frisvad-slides], not [`Vec3`], [Scene], [0, 1), [a-b]"),
        ["Igehy99", "Frisvad-slides"]
    );
}

#[test]
fn every_equation_tag_resolves_and_every_reference_is_cited() {
    let doc = root().join("src/doc");
    let table = read(&doc.join("references.md"));
    let row = |line: &str| Some(line.strip_prefix("| `")?.split_once('`')?.0.to_string());
    let known: BTreeSet<String> = table.lines().filter_map(row).collect();
    assert!(known.iter().all(|tag| is_tag(tag)) && known.len() >= 7, "references.md: {known:?}");

    let mut uses: BTreeMap<String, String> = BTreeMap::new();
    for (file, lines) in sources() {
        for line in lines {
            for tag in cited(&line.comment) {
                uses.entry(tag).or_insert_with(|| format!("src/{file}:{}", line.number));
            }
        }
    }
    for page in files(&doc, "md").iter().filter(|p| !p.ends_with("references.md")) {
        for tag in cited(&read(page)) {
            uses.entry(tag).or_insert_with(|| page.display().to_string());
        }
    }
    let unresolved = uses.iter().filter(|(tag, _)| !known.contains(*tag));
    let mut broken: Vec<String> =
        unresolved.map(|(tag, at)| format!("{at}: [{tag}] is not in src/doc/references.md")).collect();
    let uncited = known.iter().filter(|tag| !uses.contains_key(*tag));
    broken.extend(uncited.map(|tag| format!("src/doc/references.md: `{tag}` is cited nowhere")));
    report(&broken);
}

fn has_word(code: &str, word: &str) -> bool {
    let joins = |c: char| c.is_alphanumeric() || c == '_';
    code.match_indices(word).any(|(at, _)| !code[..at].ends_with(joins) && !code[at + word.len()..].starts_with(joins))
}

#[test]
fn unsafe_code_and_printing_stay_in_their_rooms() {
    let mut broken = Vec::new();
    for (file, lines) in sources() {
        let prints_allowed = file == "main.rs" || file.starts_with("cli/");
        for Line { number, code, .. } in lines {
            if has_word(&code, "unsafe") {
                broken.push(format!("src/{file}:{number}: unsafe code belongs to sys/"));
            }
            let macros = ["print!", "println!", "eprint!", "eprintln!", "dbg!"];
            let printing = macros.iter().any(|m| has_word(&code, &m[..m.len() - 1]) && code.contains(m));
            if printing && (!prints_allowed || code.contains("dbg!")) {
                broken.push(format!("src/{file}:{number}: printing belongs to src/cli"));
            }
        }
    }
    report(&broken);
    assert!(read(&root().join("src/lib.rs")).contains("#![forbid(unsafe_code)]"));
}

/// Intervals and limits are counted by the monotonic clock: one that is set in the middle of a render changes nothing.
#[test]
fn no_clock_that_can_jump_is_read() {
    let mut broken = Vec::new();
    for (file, lines) in sources() {
        let jumps = |line: &&Line| has_word(&line.code, "SystemTime") || has_word(&line.code, "UNIX_EPOCH");
        broken.extend(
            lines.iter().filter(jumps).map(|line| format!("src/{file}:{}: a clock that can jump", line.number)),
        );
    }
    report(&broken);
}

#[test]
fn every_allow_has_a_reason() {
    let mut broken = Vec::new();
    for (file, lines) in sources() {
        for (i, line) in lines.iter().enumerate() {
            // The formatter may break a long attribute over several lines.
            let attribute: String = lines[i..].iter().take(4).map(|l| l.code.as_str()).collect();
            let opens = line.code.contains("#[allow(") || line.code.contains("#![allow(");
            if opens && !attribute.split(']').next().is_some_and(|a| has_word(a, "reason")) {
                broken.push(format!("src/{file}:{}: an allow without a reason", line.number));
            }
        }
    }
    report(&broken);
}

#[test]
fn every_dependency_has_its_reason_above_it() {
    let mut broken = Vec::new();
    for manifest in ["Cargo.toml", "sys/Cargo.toml"] {
        let text = read(&root().join(manifest));
        let (mut in_dependencies, mut reason_above, mut explained) = (false, false, String::new());
        for (i, line) in text.lines().enumerate() {
            if line.starts_with('[') {
                in_dependencies = line.trim_end_matches(']').ends_with("dependencies");
            }
            let name = identifier(&line.replace('-', "_"));
            if in_dependencies && line.contains('=') && !line.starts_with(['#', ' ']) {
                // One reason covers a family: clap, clap_complete, clap_mangen.
                if reason_above {
                    explained = name;
                } else if explained.is_empty() || !name.starts_with(&format!("{explained}_")) {
                    broken.push(format!("{manifest}:{}: {name}: no reason above", i + 1));
                }
            }
            reason_above = line.starts_with('#');
        }
    }
    report(&broken);
}

/// The crate of that name in the registry reads and writes an 80-byte RTCRayHit where Embree ≥ 4.3 writes 96.
#[test]
fn embree4_sys_is_our_own() {
    let lock = read(&root().join("Cargo.lock"));
    let packages: Vec<&str> = lock.split("[[package]]").filter(|p| p.contains("name = \"embree4-sys\"")).collect();
    assert_eq!(packages.len(), 1, "one embree4-sys in Cargo.lock");
    assert!(!packages[0].contains("source ="), "embree4-sys must come from sys/, not from a registry");
}

/// A merge that loses a `mod` line would lose its tests without a word.
#[test]
fn every_test_file_is_in_its_binary() {
    let mut broken = Vec::new();
    for binary in ["fast", "statistics", "images"] {
        let folder = root().join("tests").join(binary);
        let main = read(&folder.join("main.rs"));
        for file in std::fs::read_dir(&folder).expect("a readable folder") {
            let path = file.expect("a readable entry").path();
            let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
            let module = path.extension().is_some_and(|e| e == "rs") && name != "main";
            if module && !main.lines().any(|line| line == format!("mod {name};")) {
                broken.push(format!("tests/{binary}/main.rs: no `mod {name};`"));
            }
        }
    }
    report(&broken);
}
