//! scratch
use echogrid::{grid::*, kernels::*, mapper::*, method::*, reading::*, sensor::*};
fn main() {
    let data = "/work/shared/data/sonar_ring_8/test1/";
    let res: f64 = std::env::args().nth(1).map_or(0.1, |a| a.parse().unwrap());
    let od = std::fs::read_to_string(format!("{data}od.txt")).unwrap();
    let so = std::fs::read_to_string(format!("{data}sonar.txt")).unwrap();
    let ax = [-90., -37.5, -22.5, -7.5, 7.5, 22.5, 37.5, 90f64];
    let sensors: Vec<Sensor> = ax
        .iter()
        .map(|a| Sensor {
            id: "s".into(),
            kind: Kind::Sonar,
            x: 0.,
            y: 0.,
            axis: a.to_radians(),
            half_width: 15f64.to_radians(),
            r_min: 0.17,
            r_max: 5.,
            hit_range: 5.,
            no_echo_range: 5.,
            epsilon: None,
        })
        .collect();
    let mut rs = vec![];
    let mut b = [1e9f64, 1e9, -1e9, -1e9];
    for (k, (o, s)) in od.lines().zip(so.lines()).enumerate() {
        let o: Vec<f64> = o.split_whitespace().map(|v| v.parse().unwrap()).collect();
        let s: Vec<f64> = s.split_whitespace().map(|v| v.parse().unwrap()).collect();
        let robot = Pose { x: o[1] / 1000., y: o[2] / 1000., heading: (o[3] / 10.).to_radians() };
        for i in 0..8 {
            let z = s[i + 1] / 1000.;
            let z = if s[i + 1] == 5110. { f64::INFINITY } else { z };
            let rec = Record {
                t: 0.,
                scan: k as u64,
                sensor: i as u32,
                robot,
                pose: robot.compose(0., 0., sensors[i].axis),
                range: z,
                label: None,
                line: 0,
            };
            if let Ok(r) = judge(rec, &sensors[i]) {
                let e = r.range + sensors[i].epsilon(res);
                b[0] = b[0].min(robot.x - e);
                b[1] = b[1].min(robot.y - e);
                b[2] = b[2].max(robot.x + e);
                b[3] = b[3].max(robot.y + e);
                rs.push(r);
            }
        }
    }
    let grid = GridSpec::around(b, res).unwrap();
    println!("{grid:?} {}", rs.len());
    for (name, set) in [
        ("certainty", vec![]),
        ("certainty", vec![("order", "batch")]),
        ("dempster-shafer", vec![]),
        ("bayes", vec![("region_one_floor", "0")]),
        ("bayes", vec![]),
        ("himm", vec![]),
    ] {
        let mut st = settings::Settings::of(name).unwrap();
        for (k, v) in &set {
            st.set(k, v).unwrap();
        }
        let m = make(st);
        for gpu in [false, true] {
            let mut be: Box<dyn Backend> = if gpu {
                match gpu::Gpu::new(&gpu::Options::default()) {
                    Ok(g) => Box::new(g),
                    Err(e) => {
                        println!("{e}");
                        continue;
                    }
                }
            } else {
                Box::new(cpu::Cpu::new(0).unwrap())
            };
            for batch in [100000usize, 997] {
                let t = std::time::Instant::now();
                let mut mp = Mapper::new(grid, &sensors, m.as_ref(), be.as_mut(), batch);
                for s in 0..m.sweeps().len() {
                    mp.sweep(s, rs.iter().map(|r| Ok((*r, None)))).unwrap();
                }
                let (c, w) = (mp.counts, mp.work);
                let map = mp.finish().unwrap();
                let dt = t.elapsed().as_secs_f64();
                let cl = map.layer("class").unwrap();
                let n = |v: f64| (0..cl.data.len()).filter(|k| cl.data.get(*k) == v).count();
                println!(
                    "{name} {set:?} {} batch {batch}: updates {} touched {} occ {} emp {} in {dt:.3}s {:.1} M/s outside {} empty {} bin {}us",
                    be.name(),
                    map.updates,
                    (0..cl.data.len()).filter(|k| map.layer("touched").unwrap().data.get(*k) > 0.).count(),
                    n(1.),
                    n(-1.),
                    map.updates as f64 / dt / 1e6,
                    c.outside,
                    c.empty_arc,
                    w.binning_us
                );
                let mut h = 0u64;
                for l in &map.layers {
                    let s: f64 = (0..l.data.len()).map(|k| l.data.get(k)).sum();
                    print!("  {} {s:.4}", l.name);
                    for k in 0..l.data.len() {
                        h = h.wrapping_mul(6364136223846793005).wrapping_add(l.data.get(k).to_bits());
                    }
                }
                println!(" hash {h:x}");
            }
        }
    }
}
