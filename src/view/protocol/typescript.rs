//! The TypeScript types of the protocol: the test fails where the committed file differs from the Rust types.

use super::*;
use std::path::Path;
use ts_rs::{Config, TS};

const HEAD: &str = "\
// Generated from src/view/protocol; do not edit. ECHOGRID_WRITE_TYPESCRIPT=1 cargo test --lib view::protocol writes it anew.
";

/// A type's declaration with its documentation.
fn declare<T: TS>(config: &Config) -> String {
    format!("\n{}export {}\n", T::docs().unwrap_or_default(), T::decl(config))
}

macro_rules! declarations {
    ($config:expr, $($name:ty),* $(,)?) => { [$(declare::<$name>($config)),*].concat() };
}

fn generated() -> String {
    // Every number of the protocol is below 2^53.
    let config = Config::new().with_large_int("number");
    let types = declarations!(
        &config,
        CellPoint,
        WorldPose,
        Json,
        Stamp,
        SensorKind,
        Session,
        LogSession,
        MapSession,
        Grid,
        LogSource,
        MapSource,
        ViewInfo,
        ViewGroup,
        Legend,
        MethodInfo,
        ParameterInfo,
        SensorInfo,
        LogReport,
        BadLines,
        State,
        LaneState,
        ChangedTiles,
        AllTiles,
        Current,
        CurrentReading,
        EchoOutcome,
        Outline,
        FeatureCase,
        FeatureCaseName,
        FeaturePart,
        FeatureKind,
        RoutinePart,
        CurrentScan,
        Beam,
        Cell,
        CellSource,
        NamedValue,
        CellClass,
        ChosenBeam,
        History,
        HistoryEvent,
        Region,
        Working,
        WorkingStep,
        GoRequest,
        StepUnit,
        LanesRequest,
        LaneSpec,
        GpuPlan,
        GpuStep,
        GpuSpan,
        GpuBuffer,
        GpuShader,
        GpuChunk,
        GpuBatch,
        GpuCheck,
    );
    // ts-rs leaves spaces at the ends of lines.
    format!("{HEAD}{}", types.replace(" \n", "\n"))
}

#[test]
fn the_typescript_types_are_those_of_rust() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("web/src/generated/protocol.ts");
    let generated = generated();
    if std::env::var_os("ECHOGRID_WRITE_TYPESCRIPT").is_some_and(|v| v == "1") {
        std::fs::create_dir_all(path.parent().expect("it has a folder")).expect("the folder can be made");
        std::fs::write(&path, &generated).expect("the file can be written");
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(committed == generated, "{} is not what the Rust types give: {HEAD}", path.display());
}
