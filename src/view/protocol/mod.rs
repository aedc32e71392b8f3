//! The JSON that the page and the server exchange, as types. The TypeScript types of `web/src/generated/protocol.ts` are generated from
//! them; `web/README.md` documents the requests. Lengths are metres, angles radians; numbers that are not finite are `null`.

mod cell;
mod common;
mod gpu;
mod request;
mod session;
mod state;
#[cfg(test)]
mod typescript;

pub use cell::{
    Cell, CellClass, CellSource, ChosenBeam, History, HistoryEvent, NamedValue, Region, Working, WorkingStep,
};
pub use common::{CellPoint, Json, SensorKind, Stamp, Stamped, WorldPose, finite};
pub use gpu::{GpuBatch, GpuBuffer, GpuCheck, GpuChunk, GpuPlan, GpuShader, GpuSpan, GpuStep};
pub use request::{GoRequest, LaneSpec, LanesRequest, StepUnit};
pub use session::{
    BadLines, Grid, Legend, LogReport, LogSession, LogSource, MapSession, MapSource, MethodInfo, ParameterInfo,
    SensorInfo, Session, ViewGroup, ViewInfo,
};
pub use state::{
    AllTiles, Beam, ChangedTiles, Current, CurrentReading, CurrentScan, EchoOutcome, FeatureCase, FeatureCaseName,
    FeatureKind, FeaturePart, LaneState, Outline, RoutinePart, State,
};
