//! What the traffic of a slave says otherwise than its GSD file.

use super::Described;
use super::parameters::length_text;
use profivac_gsd::{Device, Fit};
use profivac_wire::diag::SlaveDiag;
use profivac_wire::prm::{PrmStatus, SetPrm};

/// What the traffic has shown of one slave.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seen<'a> {
    /// The rate of the line in bit/s; `None` if it is not known.
    pub bits_per_second: Option<u32>,
    /// The data unit of the last Set_Prm; empty if there was none.
    pub set_prm: &'a [u8],
    /// The data unit of the last diagnosis; empty if there was none.
    pub diagnosis: &'a [u8],
    /// The longest time from the end of a request to its answer in bit times, if the times are exact.
    pub longest_tsdr: Option<u64>,
}

/// A contradiction between the line and the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mismatch {
    /// The contradiction.
    pub found: String,
    /// What to do.
    pub next: &'static str,
}

impl Mismatch {
    fn new(found: String, next: &'static str) -> Self {
        Self { found, next }
    }
}

impl Described {
    /// What the traffic says otherwise than every file that the slave may have. Empty without a file.
    #[must_use]
    pub fn mismatches(&self, seen: &Seen<'_>) -> Vec<Mismatch> {
        let each: Vec<_> = self.possible.iter().map(|file| self.mismatches_with(file.device(), seen)).collect();
        let fewest = each.into_iter().min_by_key(Vec::len).unwrap_or_default();
        self.ident_mismatch(seen).into_iter().chain(fewest).collect()
    }

    /// What Set_Prm says otherwise than every file that the slave may have.
    #[must_use]
    pub fn set_prm_mismatches(&self, du: &[u8]) -> Vec<Mismatch> {
        let seen = Seen { set_prm: du, ..Seen::default() };
        let each = self.possible.iter().map(|file| {
            let fit = self.fit_of_set_prm(file);
            set_prm(file.device(), fit.as_ref(), &seen)
        });
        each.min_by_key(Vec::len).unwrap_or_default()
    }

    fn ident_mismatch(&self, seen: &Seen<'_>) -> Option<Mismatch> {
        let (prm, diag) = (SetPrm::parse(seen.set_prm).ok()?, SlaveDiag::parse(seen.diagnosis).ok()?);
        (prm.ident != diag.ident).then(|| {
            Mismatch::new(
                format!("Set_Prm has ident {:04X}, the slave is {:04X}", prm.ident, diag.ident),
                "take the GSD file of the installed device in the engineering tool of the master, or check the address switches",
            )
        })
    }

    fn mismatches_with(&self, device: &Device, seen: &Seen<'_>) -> Vec<Mismatch> {
        let fit = (!self.config.is_empty()).then(|| Fit::new(device, &self.config));
        let mut all = Vec::new();
        if let Some(Err(error)) = &fit {
            all.push(Mismatch::new(
                format!("the configuration is not possible by the GSD file: {error}"),
                "compare the modules in the engineering tool of the master with the plugged ones; `profivac gsd show` lists those of the file",
            ));
        }
        let fit = fit.and_then(Result::ok).filter(|_| self.is_of_set_prm);
        all.extend(set_prm(device, fit.as_ref(), seen));
        all.extend(diagnosis_length(device, seen));
        all.extend(rate(device, seen));
        all
    }
}

fn set_prm(device: &Device, fit: Option<&Fit<'_>>, seen: &Seen<'_>) -> Vec<Mismatch> {
    const NEXT: &str = "take parameters and modules from the GSD file in the engineering tool of the master; `profivac gsd show` lists them";
    let Ok(prm) = SetPrm::parse(seen.set_prm) else { return Vec::new() };
    // A Set_Prm that releases the slave has no parameters.
    if prm.status.contains(PrmStatus::UNLOCK_REQ) || !prm.status.contains(PrmStatus::LOCK_REQ) {
        return Vec::new();
    }
    let mut all = Vec::new();
    let reading = fit.map_or_else(|| device.read_station_prm(prm.user), |fit| fit.read_prm(prm.user));
    let is_wrong = fit.is_some() || reading.found < reading.expected;
    if let Some(length) = length_text(&reading, fit.is_some()).filter(|_| is_wrong) {
        all.push(Mismatch::new(format!("Set_Prm has {length}"), NEXT));
    }
    let most = device.general.max_user_prm_data_len.and_then(|most| usize::try_from(most).ok());
    if let Some(most) = most.filter(|most| prm.user.len() > *most) {
        let found =
            format!("Set_Prm has {} octets of user parameters, Max_User_Prm_Data_Len is {most}", prm.user.len());
        all.push(Mismatch::new(found, NEXT));
    }
    let refused = reading.values.iter().filter(|value| value.possible.is_some() && value.covered_by.is_none());
    all.extend(refused.map(|value| Mismatch::new(format!("Set_Prm, {}: {value}", value.place), NEXT)));
    let tsdr = seen.bits_per_second.and_then(|rate| device.rate(rate)).and_then(|rate| rate.max_tsdr);
    if let Some(most) = tsdr.filter(|most| u32::from(prm.min_tsdr) > *most) {
        all.push(Mismatch::new(
            format!("Set_Prm has min T_SDR {}, MaxTsdr of the GSD file is {most} at this rate", prm.min_tsdr),
            "set min T_SDR of the master to 11, the usual value",
        ));
    }
    all
}

fn diagnosis_length(device: &Device, seen: &Seen<'_>) -> Option<Mismatch> {
    let most = usize::try_from(device.general.max_diag_data_len?).ok()?;
    (seen.diagnosis.len() > most).then(|| {
        Mismatch::new(
            format!("a diagnosis has {} octets, Max_Diag_Data_Len is {most}", seen.diagnosis.len()),
            "ask the vendor for the GSD file of this firmware: a master may refuse the longer diagnosis",
        )
    })
}

fn rate(device: &Device, seen: &Seen<'_>) -> Vec<Mismatch> {
    let Some(bits) = seen.bits_per_second else { return Vec::new() };
    let mut all = Vec::new();
    if device.check_rate(bits).is_err() {
        let found = format!("the line has {bits} bit/s, which the slave does not have by its GSD file");
        all.push(Mismatch::new(found, "choose a rate that every slave of the line has"));
    }
    if let (Some(found), Some(most)) = (seen.longest_tsdr, device.rate(bits).and_then(|rate| rate.max_tsdr))
        && found > u64::from(most)
    {
        all.push(Mismatch::new(
            format!("an answer began {found} bit times after its request, MaxTsdr is {most}"),
            "set a longer slot time in the master, and compare the GSD file with the firmware of the slave",
        ));
    }
    all
}
