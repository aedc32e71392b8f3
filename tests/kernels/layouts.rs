//! Layouts are proven, not promised: naga reads the WGSL and is held against the Rust structs; no adapter is needed.

use crate::common::{every_settings, kernels_of};
use crate::scenes;
use echogrid::geometry::layout::*;
use echogrid::kernels::gpu::adapter::Found;
use echogrid::kernels::gpu::shader::{self, Kernel};
use echogrid::kernels::gpu::{Gpu, Options};
use echogrid::method;
use echogrid::method::Unit;
use std::collections::{BTreeMap, BTreeSet};
use std::mem::offset_of;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn text(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

fn parse(source: &str, what: &str) -> naga::Module {
    naga::front::wgsl::parse_str(source).unwrap_or_else(|e| panic!("{what}: {}", e.emit_to_string(source)))
}

/// A struct: its size, and each member with its offset.
type Shape = (u32, Vec<(String, u32)>);

macro_rules! shape {
    ($name:ident: $($member:ident)*) => {
        (
            stringify!($name).to_string(),
            (size_of::<$name>() as u32, vec![$((stringify!($member).to_string(), offset_of!($name, $member) as u32)),*]),
        )
    };
}

fn rust_shapes() -> BTreeMap<String, Shape> {
    BTreeMap::from([
        shape!(Frame: size mode scale constants limits),
        shape!(Cone: sensor reach axis left right flags index shape profile),
        shape!(Tile: corner entries slot spare),
        shape!(Entry: cone slot),
        shape!(Near: cone part low high),
        shape!(Lists: chunk size near segments how pad),
        shape!(Scan: pose first count number pad),
        shape!(Beam: bound ray range id),
        shape!(Shapes: fans lines weights number flags room),
    ])
}

#[test]
fn structs_have_the_same_members_at_the_same_offsets() {
    let module = parse(&text("shaders/geometry/layout.wgsl"), "layout.wgsl");
    let mut wgsl = BTreeMap::new();
    for (_, ty) in module.types.iter() {
        if let (Some(name), naga::TypeInner::Struct { members, span }) = (&ty.name, &ty.inner) {
            let members = members.iter().map(|m| (m.name.clone().unwrap(), m.offset)).collect();
            wgsl.insert(name.clone(), (*span, members));
        }
    }
    assert_eq!(wgsl, rust_shapes());
    // The table above leaves out no struct and no member of the Rust file.
    let source = text("src/geometry/layout.rs");
    let listed = source.lines().filter_map(|l| l.strip_prefix("pub struct ")?.split_whitespace().next());
    assert_eq!(listed.collect::<BTreeSet<_>>(), wgsl.keys().map(String::as_str).collect());
    let members = source.lines().filter_map(|l| l.strip_prefix("    pub ")?.split_once(": ")).count();
    assert_eq!(members, wgsl.values().map(|(_, m)| m.len()).sum::<usize>());
}

#[test]
fn element_types_agree() {
    // What offsets can't tell: signed or not, float or not. Each member's scalar kind, by name.
    let module = parse(&text("shaders/geometry/layout.wgsl"), "layout.wgsl");
    let source = text("src/geometry/layout.rs");
    fn kind(module: &naga::Module, ty: naga::Handle<naga::Type>) -> &'static str {
        match &module.types[ty].inner {
            naga::TypeInner::Scalar(s) | naga::TypeInner::Vector { scalar: s, .. } => match s.kind {
                naga::ScalarKind::Sint => "i32",
                naga::ScalarKind::Uint => "u32",
                naga::ScalarKind::Float => "f32",
                other => panic!("{other:?}"),
            },
            naga::TypeInner::Array { base, .. } => kind(module, *base),
            other => panic!("{other:?}"),
        }
    }
    let mut checked = 0;
    for (_, ty) in module.types.iter() {
        let (Some(name), naga::TypeInner::Struct { members, .. }) = (&ty.name, &ty.inner) else { continue };
        let body = source.split(&format!("pub struct {name} {{")).nth(1).unwrap().split('}').next().unwrap();
        for member in members {
            let field = member.name.as_ref().unwrap();
            let rust = body.split(&format!("pub {field}: ")).nth(1).unwrap().lines().next().unwrap();
            let wgsl = kind(&module, member.ty);
            assert!(rust.contains(wgsl), "{name}.{field} is {rust} in Rust, of {wgsl} in WGSL");
            checked += 1;
        }
    }
    assert_eq!(checked, 45);
}

/// The value of every `const` of a module that is a plain number.
fn constants(module: &naga::Module) -> BTreeMap<String, f64> {
    let value = |c: &naga::Constant| match module.global_expressions[c.init] {
        naga::Expression::Literal(naga::Literal::I32(v)) => Some(f64::from(v)),
        naga::Expression::Literal(naga::Literal::U32(v)) => Some(f64::from(v)),
        naga::Expression::Literal(naga::Literal::F32(v)) => Some(f64::from(v)),
        _ => None,
    };
    module.constants.iter().filter_map(|(_, c)| Some((c.name.clone()?, value(c)?))).collect()
}

#[test]
fn constants_agree() {
    let found = constants(&parse(&text("shaders/geometry/layout.wgsl"), "layout.wgsl"));
    let number = |v: u32| f64::from(v);
    let wanted = BTreeMap::from(
        [
            ("CELL", f64::from(CELL)),
            ("DIRECTION", f64::from(DIRECTION)),
            ("TILE", TILE as f64),
            ("CHUNK", CHUNK as f64),
            ("BLOCK", BLOCK as f64),
            ("BLOCKS", BLOCKS as f64),
            ("SEGMENT", SEGMENT as f64),
            ("NO_ECHO", number(NO_ECHO)),
            ("NARROW_BEAM", number(NARROW_BEAM)),
            ("HALF_OPEN", number(HALF_OPEN)),
            ("WIDE", number(WIDE)),
            ("BROAD", number(BROAD)),
            ("ARC", number(ARC)),
            ("INSIDE", number(INSIDE)),
            ("ENTRY_SHIFT", number(ENTRY_SHIFT)),
            ("UNIT", f64::from(UNIT)),
            ("IDLE", number(IDLE)),
            ("YIELD", number(YIELD)),
            ("BEAM_SHIFT", number(BEAM_SHIFT)),
            ("FAN", number(FAN)),
            ("FULL", number(FULL)),
            ("LINES", number(LINES)),
            ("ROUTINE", number(ROUTINE)),
            ("FREE_LIMIT", number(FREE_LIMIT)),
            ("ARC_LIMIT", number(ARC_LIMIT)),
            ("AXIS", number(AXIS)),
            ("ARCS", number(ARCS)),
            ("FREE", number(FREE)),
            ("OCCUPY", number(OCCUPY)),
            ("COUNT", number(COUNT)),
        ]
        .map(|(name, value)| (name.to_string(), value)),
    );
    assert_eq!(found, wanted);
    // What the WGSL has no use for, and nothing else, is Rust's alone.
    let source = text("src/geometry/layout.rs");
    let mut names: BTreeSet<&str> =
        source.lines().filter_map(|l| Some(l.strip_prefix("pub const ")?.split_once(':')?.0)).collect();
    assert!(names.remove("TILE_CELLS"), "TILE_CELLS is gone from layout.rs");
    assert_eq!(names, wanted.keys().map(String::as_str).collect());
}

#[test]
fn every_kernel_parses_and_validates() {
    let mut seen = BTreeSet::new();
    for (name, settings) in every_settings() {
        let method = method::make(settings);
        let kernels = kernels_of(method.as_ref());
        let each = kernels.iter().flat_map(|k| [(*k, false, 1), (*k, true, 1), (*k, false, 8), (*k, true, 4)]);
        for (kernel, wide, groups) in each {
            let what = format!("{name}, {}, {groups}, {}", kernel.name(), if wide { "wide" } else { "narrow" });
            let module = parse(&shader::source(method.as_ref(), kernel, wide, groups), &what);
            let flags = naga::valid::ValidationFlags::all();
            let mut validator = naga::valid::Validator::new(flags, naga::valid::Capabilities::empty());
            validator.validate(&module).unwrap_or_else(|e| panic!("{what}: {e:?}"));
            let entry: Vec<_> = module.entry_points.iter().map(|e| (e.name.as_str(), e.workgroup_size)).collect();
            // A tile's cells, four times so many a thread; a thread a reading; a thread a cell.
            let threads = match (kernel, method.unit()) {
                (Kernel::Sum, _) => 64,
                (_, Unit::Scan) => TILE_CELLS as u32,
                (_, Unit::Reading | Unit::Update) => TILE_CELLS as u32 / (4 * groups),
            };
            assert_eq!(entry, [(kernel.name(), [threads, 1, 1])], "{what}");
            if kernel != Kernel::Sum {
                let planes = constants(&module)["PLANES"];
                assert_eq!(planes, method::planes(method.as_ref()) as f64, "{what}: PLANES");
            }
            seen.insert(kernel);
        }
    }
    assert_eq!(seen.len(), 4, "some driver is used by no method");
}

#[test]
fn himm_counts_in_the_same_unit() {
    use echogrid::method::himm::{HIT, MOST, ONE};
    let method = method::make(method::settings::Settings::of("himm").unwrap());
    let found = constants(&parse(&shader::source(method.as_ref(), Kernel::Fuse, true, 1), "himm"));
    assert_eq!([ONE, HIT, MOST].map(f64::from), ["ONE", "HIT", "MOST"].map(|n| found[n]));
}

fn files(folder: &Path, ending: &str, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, ending, found);
        } else if path.extension().is_some_and(|e| e == ending) {
            found.push(path);
        }
    }
}

fn relative(path: &Path) -> String {
    path.strip_prefix(root()).unwrap().to_str().unwrap().replace('\\', "/")
}

/// A path that stands in a text after `before`, up to its ending.
fn named<'a>(text: &'a str, before: &str, ending: &str) -> Vec<&'a str> {
    let starts = text.match_indices(before).map(|(at, _)| at);
    starts.filter_map(|at| Some(&text[at..at + text[at..].find(ending)? + ending.len()])).collect()
}

/// A method's file: the counting sensor models share one.
fn half(entry: &method::Entry) -> String {
    if entry.name.starts_with("csm-") { "csm".into() } else { entry.name.replace('-', "_") }
}

#[test]
fn twins_name_each_other() {
    let mut shaders = Vec::new();
    files(&root().join("shaders"), "wgsl", &mut shaders);
    assert!(shaders.len() >= 13, "{shaders:?}");
    for path in &shaders {
        let name = relative(path);
        let wgsl = text(&name);
        let first = wgsl.lines().next().unwrap();
        let twin = named(first, "twin of src/", ".rs");
        assert_eq!(twin.len(), 1, "{name}: its first line must name its twin: {first}");
        let rust = text(twin[0].strip_prefix("twin of ").unwrap());
        // `(names)` after the path are functions or types of that file.
        let parts = first.split_once(".rs (").map_or("", |(_, rest)| rest.split(')').next().unwrap());
        for part in parts.split(", ").filter(|p| !p.is_empty()) {
            let defined = ["fn", "struct"].iter().any(|kind| {
                let text = format!("{kind} {part}");
                rust.match_indices(&text)
                    .any(|(at, _)| !rust[at + text.len()..].starts_with(|c: char| c.is_alphanumeric() || c == '_'))
            });
            assert!(defined, "{name}: {} has no {part}", twin[0]);
        }
        let folder = format!("`{}/*.wgsl`", name.rsplit_once('/').unwrap().0);
        let doc: Vec<&str> = rust.lines().filter(|l| l.starts_with("//")).collect();
        let doc = doc.join("\n");
        assert!(doc.contains(&format!("`{name}`")) || doc.contains(&folder), "{}: does not name {name}", twin[0]);
    }
    let mut sources = Vec::new();
    files(&root().join("src"), "rs", &mut sources);
    let mut twins = 0;
    for path in &sources {
        let name = relative(path);
        let rust = text(&name);
        let doc: String = rust.lines().take_while(|l| l.starts_with("//!")).collect();
        for shader in named(&doc, "shaders/", "`").iter().map(|s| s.trim_end_matches('`')) {
            if let Some(folder) = shader.strip_suffix("/*.wgsl") {
                assert!(root().join(folder).is_dir(), "{name} names {folder}");
            } else if shader.ends_with(".wgsl") {
                let wgsl = text(shader);
                assert!(wgsl.lines().next().unwrap().contains(&name), "{name} names {shader}, which names another");
                twins += 1;
            }
        }
    }
    // Each method's half, odds, and layout, cone, wide, int64, narrow, profile, order, region, tile, scan, update, and what
    // passes bind; stage, and what lists tiles: near, meets, tiles.
    let halves: BTreeSet<String> = method::REGISTRY.iter().map(half).collect();
    assert_eq!(twins, halves.len() + 19);
    for half in halves {
        assert!(shaders.iter().any(|s| relative(s) == format!("shaders/method/{half}.wgsl")), "{half}");
    }
}

#[test]
fn a_whole_dispatch_on_the_noop_backend() {
    for (name, settings) in every_settings() {
        let method = method::make(settings);
        if method.cpu_only().is_some() {
            continue;
        }
        let scene = match name {
            "truth" => scenes::wide_fans(),
            _ if method.unit() == Unit::Scan => scenes::scans(),
            _ if method.unit() == Unit::Update => scenes::updates(),
            _ => scenes::wide(),
        };
        let (device, queue) = wgpu::Device::noop(&wgpu::DeviceDescriptor::default());
        let limits = device.limits();
        let found = Found {
            name: "noop".into(),
            api: "Noop".into(),
            driver: String::new(),
            software: true,
            binding: limits.max_storage_buffer_binding_size,
            buffer: limits.max_buffer_size,
            workgroups: limits.max_compute_workgroups_per_dimension,
            workgroup_memory: limits.max_compute_workgroup_storage_size,
        };
        let mut gpu = Gpu::with_device(found, device, queue, &Options::default());
        let run = scene.run(method.as_ref(), &mut gpu, echogrid::binning::batch::BATCH);
        // Nothing was computed: but every buffer, binding, pipeline and dispatch was accepted.
        assert_eq!(run.map.updates, 0, "{name}");
        assert!(run.work.entries > 100, "{name}");
    }
}
