//! The part of the acyclic server that MS1 and every MS2 connection have of their own: the response to one request.
//! profibus-wire 4.2.
//!
//! The slave acknowledges a request and passes it to the device. Most devices execute it at once; the response then waits here
//! until the master polls for it. While a device [takes time](Device::is_executing), the server acknowledges the polls. The link
//! layer repeats a fetched response if necessary, so the server is free again as soon as it has handed one over.

use super::{Device, Dpv1Error, Relation};
use crate::link::Reply;
use profivac_wire::MAX_DU;
use profivac_wire::acyclic::call::{CALL_INDEX, IM_RECORD_LENGTH, IM0};
use profivac_wire::acyclic::record::MAX_RECORD_LENGTH;
use profivac_wire::acyclic::{Access, Call, ErrorDecode, Function, Negative, Response, Transfer};

/// The server of one acyclic relation, as far as MS1 and MS2 have it in common.
#[derive(Clone, Debug)]
pub(super) struct AcyclicServer {
    response: [u8; MAX_DU],
    /// The length of the response that waits; 0 if none does.
    length: usize,
    /// The record that a Read from index 255 returns: the last Call selected I&M0.
    im0_selected: bool,
    /// The request that the device still executes.
    executing: Option<Executing>,
}

/// A request that the device executes, with what its response repeats.
#[derive(Clone, Copy, Debug)]
enum Executing {
    Read(Access),
    Write(Access),
}

impl AcyclicServer {
    pub(super) const EMPTY: Self = Self { response: [0; MAX_DU], length: 0, im0_selected: false, executing: None };

    /// Drops the response and the selection.
    pub(super) const fn clear(&mut self) {
        self.length = 0;
        self.im0_selected = false;
        self.executing = None;
    }

    /// Whether a response waits, or will.
    pub(super) const fn is_occupied(&self) -> bool {
        self.length > 0 || self.executing.is_some()
    }

    /// Whether the device still executes the request: polls are acknowledged.
    pub(super) const fn is_executing(&self) -> bool {
        self.executing.is_some()
    }

    /// The answer to a poll: the response if one waits, always with low priority.
    #[inline]
    pub(super) fn fetch<D: Device>(&mut self, device: &mut D, via: Relation, scratch: &mut [u8; MAX_DU]) -> Reply<'_> {
        let length = self.take_length(device, via, scratch);
        self.reply(length)
    }

    /// The length of the response, which counts as fetched from now on. 0 if none waits.
    #[inline]
    pub(super) fn take_length<D: Device>(
        &mut self,
        device: &mut D,
        via: Relation,
        scratch: &mut [u8; MAX_DU],
    ) -> usize {
        if self.length == 0 {
            self.complete(device, via, scratch);
        }
        core::mem::replace(&mut self.length, 0)
    }

    /// Posts the response to a request that took time, if the device has finished it.
    fn complete<D: Device>(&mut self, device: &mut D, via: Relation, scratch: &mut [u8; MAX_DU]) {
        let Some(executing) = self.executing.take_if(|_| !device.is_executing(via)) else { return };
        let record = scratch.get_mut(..MAX_RECORD_LENGTH).unwrap_or_default();
        match (device.complete(via, record), executing) {
            (Ok(whole), Executing::Read(wanted)) => self.post_record(wanted, record.get(..whole).unwrap_or_default()),
            (Ok(_), Executing::Write(access)) => self.post(&Response::Write(access)),
            (Err(error), Executing::Read(_)) => self.refuse(Function::Read, error),
            (Err(error), Executing::Write(_)) => self.refuse(Function::Write, error),
        }
    }

    /// Posts a record, cut to the length that the master wants.
    fn post_record(&mut self, wanted: Access, record: &[u8]) {
        let data = record.get(..usize::from(wanted.length)).unwrap_or(record);
        self.post(&Response::Read(Transfer { slot: wanted.slot, index: wanted.index, data }));
    }

    /// The response that was fetched with this length; SC if none waited.
    #[inline]
    pub(super) fn reply(&self, length: usize) -> Reply<'_> {
        match self.response.get(..length) {
            Some(response) if length > 0 => Reply::Low(response),
            _ => Reply::ShortAck,
        }
    }

    pub(super) fn post(&mut self, response: &Response<'_>) {
        self.length = response.emit(&mut self.response).unwrap_or(0);
    }

    pub(super) fn refuse(&mut self, function: Function, error: Dpv1Error) {
        self.post(&Response::Negative(Negative {
            function,
            decode: ErrorDecode::DpV1,
            code_1: error.code_1,
            code_2: error.code_2,
        }));
    }

    /// Executes a Read. A record longer than requested is cut, a shorter one is returned with its own length. `scratch` takes
    /// the whole record.
    pub(super) fn read<D: Device>(
        &mut self,
        device: &mut D,
        via: Relation,
        wanted: Access,
        scratch: &mut [u8; MAX_DU],
    ) {
        let Access { slot, index, .. } = wanted;
        let record = scratch.get_mut(..MAX_RECORD_LENGTH).unwrap_or_default();
        let read = match index {
            CALL_INDEX => self.read_called(device, slot, record),
            _ => device.read(via, slot, index, record),
        };
        match read {
            _ if index != CALL_INDEX && device.is_executing(via) => self.executing = Some(Executing::Read(wanted)),
            Ok(whole) => self.post_record(wanted, record.get(..whole).unwrap_or_default()),
            Err(error) => self.refuse(Function::Read, error),
        }
    }

    /// Executes a Write.
    pub(super) fn write<D: Device>(&mut self, device: &mut D, via: Relation, record: Transfer<'_>) {
        let Transfer { slot, index, data } = record;
        let written = match index {
            CALL_INDEX => self.call(device, slot, data),
            _ => device.write(via, slot, index, data),
        };
        match (written, u8::try_from(data.len())) {
            (_, Ok(length)) if index != CALL_INDEX && device.is_executing(via) => {
                self.executing = Some(Executing::Write(Access { slot, index, length }));
            }
            (Ok(()), Ok(length)) => self.post(&Response::Write(Access { slot, index, length })),
            (Ok(()), Err(_)) => self.refuse(Function::Write, Dpv1Error::TYPE_CONFLICT),
            (Err(error), _) => self.refuse(Function::Write, error),
        }
    }

    /// A Write to index 255 selects a record. profibus-wire 5.1. This slave has I&M0 only, in slot 0 only and read-only.
    fn call<D: Device>(&mut self, device: &D, slot: u8, data: &[u8]) -> Result<(), Dpv1Error> {
        // chosen: after a refused Call nothing is selected.
        self.im0_selected = false;
        im0(device, slot)?;
        let call = Call::parse(data).map_err(|_| Dpv1Error::ACCESS_DENIED)?;
        match (call.is_call(), call.fi_index, call.record) {
            (false, ..) => Err(Dpv1Error::INVALID_PARAMETER),
            (true, IM0, []) => {
                self.im0_selected = true;
                Ok(())
            }
            (true, IM0, _) => Err(Dpv1Error::ACCESS_DENIED),
            (true, ..) => Err(Dpv1Error::INVALID_INDEX),
        }
    }

    /// A Read from index 255 returns the record that was selected through the same relation.
    fn read_called<D: Device>(&self, device: &D, slot: u8, record: &mut [u8]) -> Result<usize, Dpv1Error> {
        let im0 = im0(device, slot)?;
        if !self.im0_selected {
            return Err(Dpv1Error::STATE_CONFLICT);
        }
        Call::new(IM0, &im0).emit(record).map_err(|_| Dpv1Error::TYPE_CONFLICT)
    }
}

fn im0<D: Device>(device: &D, slot: u8) -> Result<[u8; IM_RECORD_LENGTH], Dpv1Error> {
    let record = device.im0().ok_or(Dpv1Error::INVALID_INDEX)?;
    if slot == 0 { Ok(record) } else { Err(Dpv1Error::INVALID_SLOT) }
}
