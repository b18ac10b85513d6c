//! Logarithm and power of pressures, without tables: small enough for a microcontroller, and exact to 1e-14.
//!
//! Pressures have at most seven digits on the bus. The tables of `libm` for the last bit take 10 KB of a program.

/// The high and the low part of ln 2; the high one has 32 bits, so that its product with an exponent is exact.
const LN_2: (f64, f64) = (0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10);

/// The high and the low part of log10 2.
const LOG10_2: (f64, f64) = (0.301_029_995_663_611_77, 3.694_239_077_158_931e-13);

/// The bits of the mantissa.
const MANTISSA_BITS: u32 = 52;
const MANTISSA: u64 = (1 << MANTISSA_BITS) - 1;
const BIAS: i32 = 1023;

/// The natural logarithm; not a number below 0.
#[must_use]
pub fn ln(x: f64) -> f64 {
    if x.is_nan() || x < 0.0 {
        return f64::NAN;
    }
    if x == 0.0 {
        return f64::NEG_INFINITY;
    }
    if x.is_infinite() {
        return x;
    }
    // A number without its leading bit gets it by 2^54.
    let (x, scaled) = if x < f64::MIN_POSITIVE { (x * 18_014_398_509_481_984.0, 54) } else { (x, 0) };
    let bits = x.to_bits();
    let mut exponent = ((bits >> MANTISSA_BITS) as i32).wrapping_sub(BIAS).wrapping_sub(scaled);
    let mut mantissa = f64::from_bits(bits & MANTISSA | (BIAS as u64) << MANTISSA_BITS);
    if mantissa > core::f64::consts::SQRT_2 {
        mantissa *= 0.5;
        exponent = exponent.wrapping_add(1);
    }
    // ln m = 2 artanh s, |s| < 0.172: eleven terms.
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let z = s * s;
    let mut sum = 0.0;
    let mut divisor = 21.0;
    while divisor > 0.0 {
        sum = sum * z + 1.0 / divisor;
        divisor -= 2.0;
    }
    let exponent = f64::from(exponent);
    exponent * LN_2.0 + (exponent * LN_2.1 + 2.0 * s * sum)
}

/// The decadic logarithm.
#[must_use]
pub fn log10(x: f64) -> f64 {
    ln(x) * core::f64::consts::LOG10_E
}

/// e to the power of `x`.
#[must_use]
pub fn exp(x: f64) -> f64 {
    let power = libm::floor(x * core::f64::consts::LOG2_E + 0.5);
    scaled_exp(x - power * LN_2.0 - power * LN_2.1, power)
}

/// 10 to the power of `x`.
#[must_use]
pub fn exp10(x: f64) -> f64 {
    let power = libm::floor(x * core::f64::consts::LOG2_10 + 0.5);
    scaled_exp((x - power * LOG10_2.0 - power * LOG10_2.1) * core::f64::consts::LN_10, power)
}

/// e to the power of `x`, |x| < 0.35, times 2 to the power of `power`.
fn scaled_exp(x: f64, power: f64) -> f64 {
    if power > 1024.0 {
        return f64::INFINITY;
    }
    // Smaller results become 0; no pressure is so small.
    if power < -1021.0 {
        return 0.0;
    }
    let mut sum = 1.0;
    let mut term = 14.0;
    while term > 0.0 {
        sum = 1.0 + sum * x / term;
        term -= 1.0;
    }
    // Two factors, because 2^1024 is no number.
    let half = libm::floor(power * 0.5);
    sum * power_of_two(half) * power_of_two(power - half)
}

/// 2 to the power of a whole number from -511 to 512.
fn power_of_two(power: f64) -> f64 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the sum is from 512 to 1535")]
    f64::from_bits(((power + f64::from(BIAS)) as u64) << MANTISSA_BITS)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: f64, wanted: f64) -> bool {
        (found - wanted).abs() <= 2e-15 * wanted.abs().max(1e-300)
    }

    #[test]
    fn logarithms_agree_with_the_exact_ones() {
        let mut x = 1e-300;
        while x < 1e300 {
            assert!((ln(x) - libm::log(x)).abs() <= 3e-16 * libm::log(x).abs().max(1.0), "{x}");
            assert!((log10(x) - libm::log10(x)).abs() <= 5e-16 * libm::log10(x).abs().max(1.0), "{x}");
            x *= 1.001_7;
        }
    }

    #[test]
    fn powers_agree_with_the_exact_ones() {
        let mut x = -300.0;
        while x < 300.0 {
            assert!(close(exp10(x), libm::exp10(x)), "{x}: {} {}", exp10(x), libm::exp10(x));
            assert!(close(exp(x), libm::exp(x)), "{x}");
            x += 0.013;
        }
    }

    #[test]
    fn numbers_at_the_ends_of_the_range_behave() {
        assert_eq!((ln(0.0), ln(1.0), log10(1.0), exp(0.0), exp10(0.0)), (f64::NEG_INFINITY, 0.0, 0.0, 1.0, 1.0));
        assert!(ln(-1.0).is_nan() && ln(f64::NAN).is_nan() && exp(f64::NAN).is_nan() && exp10(f64::NAN).is_nan());
        assert_eq!(
            (ln(f64::INFINITY), exp(f64::INFINITY), exp(f64::NEG_INFINITY)),
            (f64::INFINITY, f64::INFINITY, 0.0)
        );
        assert_eq!((exp10(400.0), exp10(-400.0)), (f64::INFINITY, 0.0));
        assert!(close(exp10(308.0), 1e308) && (ln(5e-324) - libm::log(5e-324)).abs() < 1e-12);
    }
}
