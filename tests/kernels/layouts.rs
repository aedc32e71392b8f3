//! Layouts are proven, not promised: naga reads the WGSL and is held against the Rust structs; no adapter is needed.

use crate::common::{every_settings, kernels_of};
use crate::scenes;
use echogrid::geometry::layout::*;
use echogrid::kernels::adapter::AdapterInfo;
use echogrid::kernels::bindings::{Access, Binding, bindings};
use echogrid::kernels::cpu::Cpu;
use echogrid::kernels::gpu::program::BinnerKernel;
use echogrid::kernels::gpu::tile_binner;
use echogrid::kernels::gpu::{Gpu, Options};
use echogrid::kernels::shader::{self, Kernel};
use echogrid::kernels::{Backend, KernelError};
use echogrid::method;
use echogrid::method::{Step, Unit};
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
        shape!(ConeTileBounds: cone part low high),
        shape!(BinningParams: chunk size cones segments flags pad),
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
        for (kernel, wide, vec4s_per_thread) in each {
            let what =
                format!("{name}, {}, {vec4s_per_thread}, {}", kernel.name(), if wide { "wide" } else { "narrow" });
            let module = parse(&shader::source(method.as_ref(), kernel, wide, vec4s_per_thread).unwrap(), &what);
            let flags = naga::valid::ValidationFlags::all();
            let mut validator = naga::valid::Validator::new(flags, naga::valid::Capabilities::empty());
            validator.validate(&module).unwrap_or_else(|e| panic!("{what}: {e:?}"));
            let entry: Vec<_> = module.entry_points.iter().map(|e| (e.name.as_str(), e.workgroup_size)).collect();
            // A tile's cells, four times so many a thread; a thread a reading; a thread a cell.
            let threads = match (kernel, method.unit()) {
                (Kernel::Sum, _) => 64,
                (_, Unit::Scan) => TILE_CELLS as u32,
                (_, Unit::Reading | Unit::Update) => TILE_CELLS as u32 / (4 * vec4s_per_thread),
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
    let found = constants(&parse(&shader::source(method.as_ref(), Kernel::Fuse, true, 1).unwrap(), "himm"));
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
    // Each method's half, odds, and layout, cone, wide, int64, narrow, profile, order, region, reach, tile, scan, update, and what
    // passes bind; stage, and what lists tiles: near, meets, tiles.
    let halves: BTreeSet<String> = method::REGISTRY.iter().map(half).collect();
    assert_eq!(twins, halves.len() + 20);
    for half in halves {
        assert!(shaders.iter().any(|s| relative(s) == format!("shaders/method/{half}.wgsl")), "{half}");
    }
}

/// The bindings of group 0 that a module declares: number, name, access, bytes of an element.
fn reflected(module: &naga::Module, what: &str) -> Vec<(u32, String, Access, u64)> {
    let mut found = Vec::new();
    for (_, variable) in module.global_variables.iter() {
        let Some(binding) = &variable.binding else { continue };
        assert_eq!(binding.group, 0, "{what}");
        let access = match variable.space {
            naga::AddressSpace::Uniform => Access::Uniform,
            naga::AddressSpace::Storage { access } if access.contains(naga::StorageAccess::STORE) => Access::ReadWrite,
            naga::AddressSpace::Storage { .. } => Access::Read,
            other => panic!("{what}: {other:?}"),
        };
        let stride = match module.types[variable.ty].inner {
            naga::TypeInner::Struct { span, .. } => span,
            naga::TypeInner::Array { stride, .. } => stride,
            ref other => panic!("{what}: {other:?}"),
        };
        found.push((binding.binding, variable.name.clone().unwrap(), access, u64::from(stride)));
    }
    found.sort_by_key(|b| b.0);
    found
}

fn held(bindings: &[Binding]) -> Vec<(u32, String, Access, u64)> {
    bindings.iter().map(|b| (b.number, b.name.to_string(), b.access, b.stride)).collect()
}

#[test]
fn every_pipeline_binds_what_its_module_declares() {
    let mut layouts = BTreeSet::new();
    for (name, settings) in every_settings() {
        let method = method::make(settings);
        for kernel in kernels_of(method.as_ref()) {
            for wide in [false, true] {
                let what = format!("{name}, {}", kernel.name());
                let module = parse(&shader::source(method.as_ref(), kernel, wide, 1).unwrap(), &what);
                let bound = bindings(method.unit(), kernel).unwrap();
                assert_eq!(reflected(&module, &what), held(bound), "{what}");
                layouts.insert(bound.iter().map(|b| b.name).collect::<Vec<_>>());
            }
        }
    }
    // Readings: fuse, weigh and count, sum; scans; updates.
    assert_eq!(layouts.len(), 5, "{layouts:?}");
    let modules = tile_binner::sources().map(|source| parse(&source, "tile binner"));
    let mut kernels = 0;
    for module in &modules {
        let entries: BTreeSet<&str> = module.entry_points.iter().map(|e| e.name.as_str()).collect();
        for kernel in BinnerKernel::ALL.into_iter().filter(|k| entries.contains(k.name())) {
            assert_eq!(reflected(module, kernel.name()), held(kernel.bindings()), "{}", kernel.name());
            kernels += 1;
        }
        assert!(entries.iter().all(|e| BinnerKernel::ALL.iter().any(|k| k.name() == *e)), "{entries:?}");
    }
    assert_eq!(kernels, BinnerKernel::ALL.len());
}

#[test]
fn a_kernel_that_does_not_exist_is_an_error() {
    for (name, unit) in [("csm-discrete", Unit::Scan), ("features", Unit::Update)] {
        let method = method::make(method::settings::Settings::of(name).unwrap());
        for kernel in [Kernel::Weigh, Kernel::Count, Kernel::Sum] {
            let error = KernelError::NoKernel { kernel: kernel.name(), input: unit.name() };
            assert_eq!(shader::source(method.as_ref(), kernel, false, 1).unwrap_err(), error);
            assert_eq!(bindings(unit, kernel).unwrap_err(), error);
        }
    }
}

/// The functions that a WGSL file defines, those with an empty body left out: their twins are a trait's defaults.
fn functions(wgsl: &str) -> Vec<&str> {
    let names = wgsl.match_indices("fn ").filter(|(at, _)| *at == 0 || wgsl.as_bytes()[at - 1] == b'\n');
    let names: Vec<&str> = names.filter_map(|(at, _)| wgsl[at + 3..].split_once('(').map(|(name, _)| name)).collect();
    names
        .into_iter()
        .filter(|name| !wgsl.contains(&format!("fn {name}(cells: ptr<function, CellStates>) {{}}")))
        .collect()
}

#[test]
fn twins_have_functions_of_the_same_names() {
    // What has no function of its own in Rust, with the reason.
    const ONLY_WGSL: &[(&str, &[&str])] = &[
        // A cone's rows of a method: `Kernel::AXIS` in Rust.
        ("shaders/method/", &["member_row"]),
        // The CPU looks at a tile through `EdgeFunctions`, before it walks the tile.
        ("shaders/method/driver/weigh.wgsl", &["groups_of", "part_of_tile", "part_of_group"]),
        // One mask for three sources instead of their codes.
        ("shaders/binning/update/reach.wgsl", &["source", "part"]),
    ];
    let paired = ["shaders/method", "shaders/method/driver", "shaders/binning/update", "shaders/binning/scan"];
    // Twins by what they do: the CPU has a tile's rows where the GPU has a thread's cells.
    let apart = ["shaders/method/driver/tile.wgsl", "shaders/method/driver/stage.wgsl"];
    let (mut shaders, mut compared) = (Vec::new(), 0);
    paired.iter().for_each(|folder| files(&root().join(folder), "wgsl", &mut shaders));
    let mut unused: BTreeSet<(&str, &str)> = ONLY_WGSL.iter().flat_map(|(p, f)| f.iter().map(|f| (*p, *f))).collect();
    for path in shaders {
        let name = relative(&path);
        if apart.contains(&name.as_str()) {
            continue;
        }
        let wgsl = text(&name);
        let rust = text(named(&wgsl, "src/", ".rs")[0]);
        for function in functions(&wgsl) {
            let only = ONLY_WGSL.iter().find(|(prefix, only)| name.starts_with(prefix) && only.contains(&function));
            match only {
                Some((prefix, _)) => unused.retain(|known| *known != (*prefix, function)),
                None => {
                    let defined = [format!("fn {function}("), format!("fn {function}<")];
                    assert!(defined.iter().any(|d| rust.contains(d)), "{name}: its twin has no {function}");
                    compared += 1;
                }
            }
        }
    }
    assert!(unused.is_empty(), "no such functions: {unused:?}");
    assert!(compared >= 50, "{compared} functions compared");
}

/// The GPU backend on a device that computes nothing.
fn noop() -> Gpu {
    let (device, queue) = wgpu::Device::noop(&wgpu::DeviceDescriptor::default());
    let limits = device.limits();
    let info = AdapterInfo {
        name: "noop".into(),
        api: "Noop".into(),
        driver: String::new(),
        software: true,
        binding: limits.max_storage_buffer_binding_size,
        buffer: limits.max_buffer_size,
        workgroups: limits.max_compute_workgroups_per_dimension,
        workgroup_memory: limits.max_compute_workgroup_storage_size,
    };
    Gpu::with_device(info, device, queue, &Options::default())
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
        let mut gpu = noop();
        let run = scene.run(method.as_ref(), &mut gpu, echogrid::binning::batch::BATCH);
        // Nothing was computed: but every buffer, binding, pipeline and dispatch was accepted.
        assert_eq!(run.map.updates, 0, "{name}");
        assert!(run.statistics.entries > 100, "{name}");
    }
}

#[test]
fn a_batch_that_does_not_fit_its_method_is_an_error() {
    use echogrid::binning::batch::{Batch, ChunkList, Input, ScanInput};
    let frame = Frame { size: [64, 64], mode: 0, scale: 1.0, constants: [[0.0; 4]; 2], limits: [0; 4] };
    let bayes = method::make(method::settings::Settings::of("bayes").unwrap());
    let tiles = vec![Tile { corner: [0, 0], entries: [0, 0], slot: 0, spare: [0; 3] }];
    let chunks = vec![ChunkList { tiles, ..ChunkList::default() }];
    let scans = Batch { chunks: chunks.clone(), input: Input::Scans(ScanInput::default()) };
    let readings = Batch { chunks, input: Input::Cones(Default::default()) };
    let mut backends: [Box<dyn Backend>; 2] = [Box::new(noop()), Box::new(Cpu::new(1).unwrap())];
    for backend in &mut backends {
        let error = backend.apply(bayes.as_ref(), frame, &scans, bayes.sweeps()[0], &mut Vec::new()).unwrap_err();
        assert_eq!(
            (error.kind(), error.to_string().contains("takes readings was given scans")),
            (echogrid::ErrorKind::NoAdapter, true),
            "{error}"
        );
    }
    // A step that reads counts which no step before it makes.
    let counts = noop().apply(bayes.as_ref(), frame, &readings, &[Step::AccumulateCounts], &mut Vec::new());
    assert!(counts.unwrap_err().to_string().contains("lacks its buffer \"parts\""));
}
