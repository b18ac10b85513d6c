//! Random plants with their own integration, which shares no code with the fit.

use profivac_identify::plant::{Dose, Phase, PlantRecord, Volume};

const HOUR_S: f64 = 3600.0;

/// A random number of mean 0 and standard deviation 1.
pub fn normal(random: &mut fastrand::Rng) -> f64 {
    (-2.0 * (1.0 - random.f64()).ln()).sqrt() * (std::f64::consts::TAU * random.f64()).cos()
}

/// How a plant differs from the law of the fit.
#[derive(Clone, Copy, Debug, Default)]
pub struct Imperfection {
    /// The pumping speed below 1 Pa is larger by this multiple: a turbo that takes over from its backing pump.
    pub turbo: f64,
    /// The share of the outgassing after an hour that comes from polymers: exponent ½.
    pub polymer: f64,
    /// The share of samples with ten times the noise.
    pub outliers: f64,
    /// The standard deviation of a drift of the gauge with a time constant of ten minutes.
    pub drift: f64,
    /// The gauge shows two digits.
    pub two_digits: bool,
    /// The given volume is too large by this part.
    pub volume: f64,
}

/// The time constant of a drift, in s.
const DRIFT_S: f64 = 600.0;

/// The true numbers of a plant, in Pa, m³, s.
#[derive(Clone, Debug)]
pub struct Truth {
    pub volume_m3: f64,
    /// The pumping speed at 1 Pa, and its exponent over the pressure.
    pub speed: f64,
    pub steepness: f64,
    pub leak: f64,
    pub outgassing_1h: f64,
    pub exponent: f64,
    pub ultimate_pa: f64,
    /// The time constant with which water returns to the wall, and the share that does not return.
    pub return_s: f64,
    pub share: f64,
    /// The relative noise of the gauge and its range in Pa.
    pub noise: f64,
    pub range: [f64; 2],
    /// The time of pumping and of the closed valve, in s, and between two samples.
    pub pumped_s: f64,
    pub rise_s: f64,
    pub every_s: f64,
    pub dosed: bool,
    /// The age of the wall at the start of the pump-down, in s.
    pub age_s: f64,
    pub imperfection: Imperfection,
}

impl Truth {
    /// Volumes from 1 l to 10 m³, noise from 0.5 to 5 %, exponents from 0.7 to 1.3.
    pub fn of(seed: u64) -> Self {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut between = |from: f64, to: f64| from * (to / from).powf(random.f64());
        let volume_m3 = between(1e-3, 10.0);
        let speed = volume_m3 * between(0.05, 5.0);
        let area = 6.0 * volume_m3.powf(2.0 / 3.0) * between(1.0, 3.0);
        let outgassing_1h = area * between(1e-7, 1e-5);
        let leak = outgassing_1h * between(1e-3, 3.0);
        let base = outgassing_1h / speed;
        Self {
            volume_m3,
            speed,
            leak,
            outgassing_1h,
            exponent: between(0.7, 1.3),
            ultimate_pa: base * between(1e-3, 1.0),
            return_s: between(1e3, 1e6),
            noise: between(0.005, 0.05),
            range: [base * between(1e-3, 0.03), between(10.0, 1e5)],
            pumped_s: between(2.0, 24.0) * HOUR_S,
            rise_s: between(0.2, 2.0) * HOUR_S,
            every_s: between(1.0, 10.0),
            age_s: between(1.0, 30.0),
            share: random.f64(),
            steepness: 0.1 * (random.f64() - 0.5),
            dosed: random.u8(0..4) == 0,
            imperfection: Imperfection::default(),
        }
    }

    pub fn speed_at(&self, pa: f64) -> f64 {
        self.speed * pa.powf(self.steepness) * (1.0 + self.imperfection.turbo / (1.0 + pa * pa))
    }

    /// The outgassing of a wall of an age in s, in Pa m³/s.
    fn outgassed(&self, age: f64) -> f64 {
        let hours = age / HOUR_S;
        let polymer = self.imperfection.polymer;
        self.outgassing_1h * ((1.0 - polymer) * hours.powf(-self.exponent) + polymer * hours.powf(-0.5))
    }

    /// What the gauge indicates for a pressure.
    fn indicated(&self, pa: f64, drift: f64, random: &mut fastrand::Rng) -> f64 {
        let Imperfection { outliers, two_digits, .. } = self.imperfection;
        let wide = if outliers > 0.0 && random.f64() < outliers { 10.0 } else { 1.0 };
        let shown = pa * (1.0 + drift + wide * self.noise * normal(random)).max(0.01);
        let last = 10_f64.powf(shown.log10().floor() - 1.0);
        if two_digits { (shown / last).round() * last } else { shown }
    }

    /// The pressures of dry gas and water and the age of the wall after a short step, with the rates in its middle.
    fn step(&self, state: [f64; 3], seconds: f64, pumped: bool) -> [f64; 3] {
        let middle = self.euler(state, state, seconds / 2.0, pumped);
        self.euler(state, middle, seconds, pumped)
    }

    /// The state after a step with the rates of another state.
    fn euler(&self, from: [f64; 3], [dry, water, age]: [f64; 3], seconds: f64, pumped: bool) -> [f64; 3] {
        let speed = if pumped { self.speed_at(dry + water) / self.volume_m3 } else { 0.0 };
        let gas = self.outgassed(age) / self.volume_m3;
        let towards = |value: f64, source: f64, rate: f64| {
            let decay = (-rate * seconds).exp();
            value * decay + if rate > 0.0 { source / rate * (1.0 - decay) } else { source * seconds }
        };
        let wetted = water * self.volume_m3 / (self.return_s * self.outgassing_1h * HOUR_S);
        [
            towards(from[0], self.leak / self.volume_m3 + speed * self.ultimate_pa + self.share * gas, speed),
            towards(from[1], (1.0 - self.share) * gas, speed + 1.0 / self.return_s),
            (from[2] + (1.0 - wetted * age) * seconds).max(1.0),
        ]
    }

    /// The pressure with the valve open all the time, in Pa.
    pub fn pumped_pa(&self, seconds: f64) -> f64 {
        let [dry, water, _] = self.pumped(seconds);
        dry + water
    }

    /// The parts of that pressure by the leak, by outgassing and by the pump, in Pa.
    pub fn parts_pa(&self, seconds: f64) -> [f64; 3] {
        let [dry, water, age] = self.pumped(seconds);
        let speed = self.speed_at(dry + water);
        [self.leak / speed, self.outgassed(age) / speed, self.ultimate_pa]
    }

    fn pumped(&self, seconds: f64) -> [f64; 3] {
        let (mut state, mut now) = ([self.range[1].min(1e3), 0.0, self.age_s], 0.0);
        while now < seconds {
            let step = self.short(now).min(seconds - now);
            state = self.step(state, step, true);
            now += step;
        }
        state
    }

    /// A step that is short beside the age of the wall, and at first beside the time constant of the chamber.
    fn short(&self, seconds: f64) -> f64 {
        (0.01 * self.volume_m3 / self.speed / (1.0 + self.imperfection.turbo)).min(0.01).max(2e-4 * seconds)
    }

    pub fn record(&self, seed: u64) -> PlantRecord {
        let mut random = fastrand::Rng::with_seed(!seed);
        let closed = self.pumped_s;
        let dose = Dose { at_s: closed + 0.6 * self.rise_s, amount: 0.0 };
        let (mut state, mut now) = ([self.range[1].min(1e3), 0.0, self.age_s], 0.0);
        let (mut samples, mut next, mut amount) = (Vec::new(), 0.0, None);
        // The drift of the gauge, and the time of its last change.
        let mut drift = (0.0, 0.0);
        let end = closed + self.rise_s;
        while now < end {
            let pumped = now < closed;
            if self.dosed && !pumped && now >= dose.at_s && amount.is_none() {
                let given = 3.0 * (state[0] + state[1]) * self.volume_m3;
                state[0] += given / self.volume_m3;
                amount = Some((now, given));
            }
            if now >= next {
                let since = now - drift.1;
                let kept = (-since / DRIFT_S).exp();
                let size = self.imperfection.drift * (1.0 - kept * kept).sqrt();
                let moved = if size > 0.0 { size * normal(&mut random) } else { 0.0 };
                drift = (drift.0 * kept + moved, now);
                let pa = self.indicated(state[0] + state[1], drift.0, &mut random);
                let [low, high] = self.range;
                if pa >= low && pa < high {
                    samples.push((now, pa));
                }
                next = now + if now < 120.0 { 0.2 } else { self.every_s };
            }
            let until = if pumped { closed } else { end };
            let step = self.short(if pumped { now } else { now - closed }).min(until - now).min((next - now).max(1e-3));
            state = self.step(state, step, pumped);
            now += step;
        }
        let given = self.volume_m3 * (1.0 + self.imperfection.volume);
        let volume =
            amount.map_or(Volume::Given(given), |(at_s, amount)| Volume::FromDose(Dose { at_s: at_s - 1e-6, amount }));
        let phases = vec![Phase { from_s: 0.0, pumped: true }, Phase { from_s: closed, pumped: false }];
        PlantRecord { samples, phases, volume, gauge_uncertainty: 0.0 }
    }
}
