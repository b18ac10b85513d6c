//! Every pressure of an accepted scenario is finite and above zero, and every indication is a number.

use profivac_virtual::scenario::{MasterPresence, Scenario};

/// How many files are tried.
const FILES: usize = 400;

/// The steps of a file.
const STEPS: u32 = 12;

/// A number from one to another, evenly on a logarithmic scale, or one that no plant has.
fn number(rng: &mut fastrand::Rng, from: f64, to: f64) -> String {
    const ODD: [&str; 8] = ["0", "-1", "nan", "inf", "-0", "1e-300", "1e300", "5e-324"];
    if rng.u8(..40) == 0 {
        return rng.choice(ODD).unwrap_or_default().to_owned();
    }
    format!("{:e}", from * (to / from).powf(rng.f64()))
}

/// A plant with one part of each kind, with quantities up to the ends of their ranges and sometimes beyond.
fn plant(rng: &mut fastrand::Rng) -> String {
    let mut n = |from, to| number(rng, from, to);
    let volumes = ["chamber", "throat", "fore"]
        .map(|name| format!("{name} = {{ volume = \"{} m3\", pressure = \"{} Pa\" }}\n", n(1e-9, 1e6), n(1e-13, 1e6)));
    let flow = n(1e-12, 1e6);
    let text = format!(
        "title = \"t\"\nuntil = \"10 d\"\nstep = \"{} s\"\natmosphere = {{ pressure = \"{} Pa\", humidity = \"{} %\" }}\n[volumes]\n{}\
         [walls]\nw = {{ in = \"chamber\", material = \"MATERIAL\", area = \"{} m2\", aged = \"{} s\", aged_at = \"{} K\" }}\n\
         [valves]\ngate = {{ between = [\"chamber\", \"throat\"], diameter = \"{} m\", length = \"{} m\" }}\n\
         [tubes]\nt = {{ between = [\"throat\", \"fore\"], conductance = \"{} m3/s\", open = OPEN }}\n\
         [pockets]\np = {{ in = \"chamber\", volume = \"{} m3\", conductance = \"{} m3/s\" }}\n\
         [roughing-pumps]\nr = {{ at = \"fore\", speed = \"{} m3/s\", ultimate = \"{} Pa\", running = true }}\n\
         [turbo-pumps]\nu = {{ inlet = \"throat\", fore = \"fore\", speed = \"{} m3/s\", compression = {}, critical-pressure = \"{} Pa\", \
         spin-up = \"{} s\", running = true }}\n\
         [leaks]\nl = {{ at = \"chamber\", rate = \"{} Pa m3/s\", open = true }}\n\
         [vents]\nv = {{ at = \"chamber\", diameter = \"{} m\", length = \"{} m\", gas = \"GAS\", open = OPEN }}\n\
         [inlets]\ni = {{ at = \"chamber\", gas = \"GAS\" }}\n\
         [seals]\ns = {{ in = \"chamber\", area = \"{} m2\", thickness = \"{} m\", permeabilities = {{ he = \"{} m2/s\", n2 = \"1e-12 m2/s\" }} }}\n\
         [gauges]\n\"bcg450@3\" = \"chamber\"\n\"pcg550@4\" = \"throat\"\n\"tpg500@5\" = \"fore\"\n\
         [[timeline]]\nat = \"0 s\"\nflow = [{{ inlet = \"i\", SUPPLY }}]\nheat = [{{ wall = \"w\", to = \"{} K\" }}]\n",
        n(1e-3, 3600.0),
        n(1e-13, 1e6),
        n(1e-3, 100.0),
        volumes.concat(),
        n(1e-6, 1e6),
        n(1e-3, 3e9),
        n(1.0, 2000.0),
        n(1e-6, 1e3),
        n(1e-6, 1e3),
        n(1e-18, 1e6),
        n(1e-9, 1e6),
        n(1e-18, 1e6),
        n(1e-18, 1e6),
        n(1e-13, 1e6),
        n(1e-18, 1e6),
        n(1.0, 1e15),
        n(1e-13, 1e6),
        n(1e-3, 1e6),
        n(1e-12, 1e6),
        n(1e-6, 1e3),
        n(1e-6, 1e3),
        n(1e-6, 1e6),
        n(1e-6, 1e3),
        n(1e-20, 1e-3),
        n(1.0, 2000.0),
    );
    let material = rng.choice(["steel", "glass", "viton", "aluminium"]).unwrap_or_default();
    let gas = rng.choice(["n2", "he", "xe", "h2", "air"]).unwrap_or_default();
    let supply = if rng.bool() { format!("flow = \"{flow} Pa m3/s\"") } else { format!("pressure = \"{flow} Pa\"") };
    let open = if rng.bool() { "true" } else { "false" };
    text.replace("MATERIAL", material).replace("GAS", gas).replace("SUPPLY", &supply).replace("OPEN", open)
}

#[test]
fn accepted_scenarios_stay_finite_and_positive() {
    let seed = 118;
    let mut rng = fastrand::Rng::with_seed(seed);
    let (mut accepted, mut refused) = (0, 0);
    for file in 0..FILES {
        let text = plant(&mut rng);
        let scenario = match Scenario::parse(&text, "x.toml") {
            Ok(scenario) => scenario,
            Err(error) => {
                assert!(error.to_string().contains(": expected "), "{error}");
                refused += 1;
                continue;
            }
        };
        accepted += 1;
        let mut devices = super::devices(&scenario);
        let mut run = scenario.start(MasterPresence::Absent);
        for step in 0..STEPS {
            run.step(&mut devices);
            for (name, pa) in run.pressures() {
                let context = format!("{name} has {pa:e} Pa after step {step}, file {file} of seed {seed}:\n{text}");
                assert!(pa.is_finite() && pa > 0.0, "{context}");
            }
            for device in &devices {
                let report = device.report();
                let is_number = report.indicated.iter().all(|shown| shown.value_mbar.is_finite());
                assert!(is_number, "{report:?} after step {step}, file {file} of seed {seed}:\n{text}");
            }
        }
    }
    assert!(accepted > FILES / 4 && refused > FILES / 10, "{accepted} accepted, {refused} refused");
}
