//! Criterion's view of the kernels: cell updates a second for each method and backend on 30° cones of 5 m and 2 m.
//!
//! `cargo bench` compares with the run before; `echogrid bench` prints the table of `benches/results/`.
#![allow(missing_docs, reason = "criterion's macros make items without documentation")]
#![allow(clippy::unwrap_used, reason = "a benchmark stops where it can't run")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use echogrid::bench::throughput::measure;
use echogrid::bench::workload::standard;
use echogrid::binning::batch::BATCH;
use echogrid::kernels::{Choice, choose};
use echogrid::method::{REGISTRY, Unit, make, settings::Settings};
use echogrid::pipeline::mapper::Mapper;

fn kernels(c: &mut Criterion) {
    // The 2 cm workloads take seconds a run: `echogrid bench` has them.
    let workloads = standard(20_000);
    for choice in [Choice::Cpu, Choice::Gpu] {
        for entry in REGISTRY.iter().filter(|e| e.name != "truth") {
            let method = make(Settings::of(entry.name).unwrap());
            if method.unit() != Unit::Reading {
                continue;
            }
            let Ok(mut chosen) = choose(choice, method.as_ref(), 0) else {
                eprintln!("SKIPPED {}: no adapter", entry.name);
                continue;
            };
            let mut group = c.benchmark_group(format!("{} {}", chosen.backend.name(), entry.name));
            group.sample_size(10);
            for workload in &workloads[..2] {
                let updates = measure(workload, method.as_ref(), chosen.backend.as_mut(), 1).unwrap().updates;
                group.throughput(Throughput::Elements(updates));
                group.bench_function(&workload.name, |b| {
                    b.iter(|| {
                        let backend = chosen.backend.as_mut();
                        let sensors = &workload.sensors;
                        let mapper = Mapper::new(workload.grid, sensors, method.as_ref(), backend, BATCH).unwrap();
                        let mut mapper = mapper.without_counts();
                        for sweep in 0..method.sweeps().len() {
                            mapper.sweep(sweep, workload.readings.iter().map(|r| Ok((*r, None)))).unwrap();
                        }
                        mapper.wait().unwrap();
                    });
                });
            }
        }
    }
}

criterion_group!(benches, kernels);
criterion_main!(benches);
