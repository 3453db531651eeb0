use lacuna_discrepancy::{screen::Screen, weak::WeakForm, Dataset, Predictor};
use lacuna_plants::Model;
fn main() {
    let mut a = std::env::args().skip(1);
    let model = Model::read(std::path::Path::new(&a.next().unwrap())).unwrap_or_else(|e| { eprintln!("{e}"); std::process::exit(2) });
    let sources: Vec<_> = a.map(|s| s.parse().unwrap()).collect();
    let t0 = std::time::Instant::now();
    let data = Dataset::read(&model, &sources).unwrap_or_else(|e| { eprintln!("{e}"); std::process::exit(2) });
    println!("read {:?} noise {:?}", t0.elapsed(), data.noise);
    let p = Predictor::new(&model, &data);
    for r in &data.recordings { let f = p.free_run(r, 50); println!("free {} {:?} substeps", r.name, (0..data.outputs.len()).map(|k| f.rmse(r, k)).collect::<Vec<_>>()); break; }
    println!("pred {:?}", t0.elapsed());
    let weak = WeakForm::new(&model, &data).unwrap();
    println!("weak {:?} rows {}", t0.elapsed(), weak.rows());
    let mut s = Screen::new(&weak, model.values());
    let out = s.search(&|m| println!("{m}")).unwrap();
    println!("search {:?} nominal {:.1} calibrated {:.1} chosen {:.1}", t0.elapsed(), out.nominal.evidence.log, out.calibrated.evidence.log, out.chosen.evidence.log);
    let free = s.free_parameters();
    for (i, k) in free.iter().enumerate() { println!("  {} = {} +- {}", model.parameters[*k].name, s.point[*k] + out.chosen.evidence.coefficients[i], out.chosen.evidence.std(i)); }
    for (i, t) in out.chosen.terms.iter().enumerate() { println!("FOUND {}@{} {:?} gain {:.1} rivals {:?}", t.candidate.effect.class, t.candidate.channel, t.shape, out.gains[i], out.rivals[i].iter().map(|(c, g)| (c.effect.class, c.channel, *g as i64)).collect::<Vec<_>>()); }
    println!("coef {:?}", &out.chosen.evidence.coefficients[free.len()..]);
}
