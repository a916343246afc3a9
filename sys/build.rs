//! Finds the installed Embree, generates its raw declarations and compiles the C shim.
//!
//! Environment: `EMBREE_PREFIX` (folder with `include/` and `lib/`), `EMBREE_MAJOR` (`3` or `4`) where both are
//! installed or the choice must be forced, `LIBCLANG_PATH` for bindgen. Passed on to dependent build scripts:
//! `DEP_EMBREE_VERSION`, `DEP_EMBREE_MAJOR` and, with a prefix, `DEP_EMBREE_INCLUDE` and `DEP_EMBREE_LIBDIR`.

use std::env;
use std::fs;
use std::panic;
use std::path::{Path, PathBuf};

const INSTALL: &str = "install libembree-dev and libclang-dev (set EMBREE_PREFIX if Embree is elsewhere), or build with \
    --no-default-features for the pure-Rust backend.";
const NO_CLANG: &str = "libclang was not found or cannot read Embree's headers: install libclang-dev (set LIBCLANG_PATH \
    if it is elsewhere), or build with --no-default-features for the pure-Rust backend.";
const NO_CC: &str = "no working C compiler was found: install gcc (and libc6-dev), or build with --no-default-features \
    for the pure-Rust backend.";

fn main() {
    for file in ["build.rs", "shim.c", "shim.h"] {
        println!("cargo::rerun-if-changed={file}");
    }
    for variable in ["EMBREE_PREFIX", "EMBREE_MAJOR", "CPATH", "C_INCLUDE_PATH"] {
        println!("cargo::rerun-if-env-changed={variable}");
    }
    // One sentence, drawn by cargo as the crate's error; no panic message around it.
    if let Err(sentence) = build() {
        println!("cargo::error={sentence}");
    }
}

fn build() -> Result<(), String> {
    let place = Place::from_environment()?;
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("cargo did not set OUT_DIR")?);
    let header = ask_preprocessor(&place, &out)?;
    generate(&place, &header, &out)?;
    compile_shim(&place, &header)?;
    link(&place, &header);
    Ok(())
}

/// Where to look, as the environment says it.
struct Place {
    include: Option<PathBuf>,
    libdir: Option<PathBuf>,
    major: Option<u32>,
}

impl Place {
    fn from_environment() -> Result<Self, String> {
        let major = match env::var("EMBREE_MAJOR") {
            Err(_) => None,
            Ok(text) => match text.trim() {
                "3" => Some(3),
                "4" => Some(4),
                _ => return Err(format!("EMBREE_MAJOR is '{text}', but must be 3 or 4.")),
            },
        };
        let Some(prefix) = env::var_os("EMBREE_PREFIX").map(PathBuf::from) else {
            return Ok(Self { include: None, libdir: None, major });
        };
        let include = prefix.join("include");
        // Decided by the prefix alone: the preprocessor would also find a newer header in the system's folders.
        let has = |major: &u32| include.join(format!("embree{major}/rtcore.h")).is_file();
        let candidates = major.map_or(vec![4, 3], |forced| vec![forced]);
        let major = candidates.into_iter().find(has).ok_or_else(|| {
            format!("EMBREE_PREFIX is '{}', but its folder include has no {}.", prefix.display(), wanted(major))
        })?;
        let multiarch = format!("lib/{}-linux-gnu", env::var("CARGO_CFG_TARGET_ARCH").unwrap_or_default());
        let libdir = ["lib", "lib64", multiarch.as_str()]
            .iter()
            .map(|folder| prefix.join(folder))
            .find(|folder| has_library(folder, major))
            .ok_or_else(|| format!("EMBREE_PREFIX is '{}', but has no libembree{major} in lib.", prefix.display()))?;
        Ok(Self { include: Some(include), libdir: Some(libdir), major: Some(major) })
    }

    fn clang_arguments(&self, header: &Header) -> Vec<String> {
        let mut arguments = vec![format!("-DPDE_EMBREE_MAJOR={}", header.major)];
        arguments.extend(self.include.iter().map(|folder| format!("-I{}", folder.display())));
        arguments
    }
}

/// The header that was looked for, for messages.
fn wanted(major: Option<u32>) -> String {
    major.map_or("embree4/rtcore.h or embree3/rtcore.h".into(), |major| format!("embree{major}/rtcore.h"))
}

fn has_library(folder: &Path, major: u32) -> bool {
    let stem = format!("libembree{major}.");
    fs::read_dir(folder).is_ok_and(|mut entries| {
        entries.any(|entry| entry.is_ok_and(|entry| entry.file_name().to_string_lossy().starts_with(&stem)))
    })
}

/// The header that the C preprocessor sees.
struct Header {
    major: u32,
    version: String,
}

/// The preprocessor searches where the compiler will; a search of our own could find another header.
fn ask_preprocessor(place: &Place, out: &Path) -> Result<Header, String> {
    let include = |major: u32| format!("#include <embree{major}/rtcore_config.h>\n");
    let choice = match place.major {
        Some(major) => format!("#if __has_include(<embree{major}/rtcore.h>)\n{}#endif\n", include(major)),
        None => format!(
            "#if __has_include(<embree4/rtcore.h>)\n{}#elif __has_include(<embree3/rtcore.h>)\n{}#endif\n",
            include(4),
            include(3)
        ),
    };
    let probe = out.join("probe.c");
    let text = format!("{choice}pde_probe_begin RTC_VERSION_MAJOR RTC_VERSION RTC_VERSION_STRING pde_probe_end\n");
    fs::write(&probe, text).map_err(|error| format!("cannot write {}: {error}.", probe.display()))?;

    let mut compiler = cc::Build::new();
    compiler.file(&probe).cargo_metadata(false).cargo_warnings(false).includes(&place.include);
    let expanded = compiler.try_expand().map_err(|_| NO_CC)?;
    parse_probe(&String::from_utf8_lossy(&expanded), place)
}

fn parse_probe(expanded: &str, place: &Place) -> Result<Header, String> {
    // gcc puts line markers ("# 1 file") around tokens that come from system headers.
    let tokens: Vec<&str> =
        expanded.lines().filter(|line| !line.trim_start().starts_with('#')).flat_map(str::split_whitespace).collect();
    let begin = tokens.iter().position(|token| *token == "pde_probe_begin").ok_or(NO_CC)?;
    let [major, number, version, "pde_probe_end"] = tokens[begin + 1..] else {
        return Err(format!("Embree 3.13 or 4.x was not found: {INSTALL}"));
    };
    let (Ok(major), Ok(number)) = (major.parse::<u32>(), number.parse::<u32>()) else {
        // Without a header the macros stay the names they are.
        return Err(match place.major {
            Some(_) => format!("{} was not found, but EMBREE_MAJOR asks for it: {INSTALL}", wanted(place.major)),
            None => format!("Embree 3.13 or 4.x was not found: {INSTALL}"),
        });
    };
    let version = version.trim_matches('"').to_string();
    // 3.13 is the oldest whose callbacks have the fields that the shim reads.
    if number < 31300 || major > 4 {
        return Err(format!("Embree {version} is not supported, only 3.13 and 4.x: {INSTALL}"));
    }
    Ok(Header { major, version })
}

fn generate(place: &Place, header: &Header, out: &Path) -> Result<(), String> {
    let builder = bindgen::Builder::default()
        .header("shim.h")
        .clang_args(place.clang_arguments(header))
        .parse_callbacks(Box::new(bindgen::CargoCallbacks::new()))
        // A newer library may return codes that this header does not know: integers, never Rust enums.
        .default_enum_style(bindgen::EnumVariation::Consts)
        .prepend_enum_name(false)
        .generate_cstr(true)
        .layout_tests(true)
        .derive_default(false)
        .allowlist_function("pde_.*")
        .allowlist_function(
            "rtc((New|Release)(Device|Geometry|Scene)|(Get|Set)DeviceError(Function)?|GetDeviceProperty\
             |CommitGeometry|SetGeometry(BuildQuality|InstancedScene|Mask|TimeRange|TimeStepCount|Transform)|SetNewGeometryBuffer\
             |AttachGeometryByID|CommitScene|SetScene(BuildQuality|Flags))",
        )
        .allowlist_type("Pde.*")
        .allowlist_var("PDE_.*")
        .allowlist_var("RTC_(VERSION(_MAJOR|_STRING)?|MAX_TIME_STEP_COUNT|ERROR_.*|DEVICE_PROPERTY_VERSION)")
        .allowlist_var("RTC_(GEOMETRY_TYPE_(TRIANGLE|USER|INSTANCE)|SCENE_FLAG_(NONE|ROBUST)|BUILD_QUALITY_MEDIUM)")
        .allowlist_var("RTC_(BUFFER_TYPE_(INDEX|VERTEX)|FORMAT_(UINT3|FLOAT3|FLOAT3X4_ROW_MAJOR))");
    // bindgen panics where libclang cannot be loaded; the sentence says what to do, the backtrace does not.
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| ()));
    let generated = panic::catch_unwind(panic::AssertUnwindSafe(|| builder.generate()));
    panic::set_hook(hook);
    let bindings = match generated {
        Err(_) => return Err(NO_CLANG.into()),
        Ok(Err(error)) => {
            return Err(format!("{NO_CLANG} ({})", error.to_string().trim().replace('\n', "; ")));
        }
        Ok(Ok(bindings)) => bindings,
    };
    let file = out.join("bindings.rs");
    bindings.write_to_file(&file).map_err(|error| format!("cannot write {}: {error}.", file.display()))
}

fn compile_shim(place: &Place, header: &Header) -> Result<(), String> {
    cc::Build::new()
        .file("shim.c")
        .std("c11")
        .define("PDE_EMBREE_MAJOR", header.major.to_string().as_str())
        .includes(&place.include)
        .warnings(true)
        .extra_warnings(true)
        .warnings_into_errors(false)
        .try_compile("pde_shim")
        .map_err(|error| format!("the C shim over Embree {} does not compile: {error}.", header.version))
}

fn link(place: &Place, header: &Header) {
    println!("cargo::rustc-link-lib=embree{}", header.major);
    println!("cargo::metadata=VERSION={}", header.version);
    println!("cargo::metadata=MAJOR={}", header.major);
    if let Some(include) = &place.include {
        println!("cargo::metadata=INCLUDE={}", include.display());
    }
    if let Some(libdir) = &place.libdir {
        println!("cargo::rustc-link-search=native={}", libdir.display());
        println!("cargo::metadata=LIBDIR={}", libdir.display());
        // Only this crate's own tests: a dependent crate's build.rs does the same with DEP_EMBREE_LIBDIR.
        println!("cargo::rustc-link-arg-tests=-Wl,-rpath,{}", libdir.display());
    }
}
