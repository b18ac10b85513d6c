//! The device as its slave sees it: tables, a copy of the inputs, and the requests of masters.

use super::exchanged::{Access, ChannelRead, Commands, Done, Job, MAX_CHANGES, Record, Snapshot, Tasks, Via};
use crate::model::{AccessError, Configuration, Field, MAX_IMAGE, Model, Octets, Telegram, UserPrm};
use crate::profile::Behaviour;
use crate::profile::device::BlockDevice;
use crate::profile::parameter_channel::{self, ParameterChannel, Task};
use crate::store::Store;
use profivac_dp::slave::{CfgFault, Device, Diagnosis, Dpv1Error, Features, Outputs, PrmFault, Relation};
use profivac_wire::acyclic::ErrorCode;
use profivac_wire::acyclic::call::IM_RECORD_LENGTH;
use profivac_wire::address::SetSlaveAdd;
use profivac_wire::cfg::Lengths;

/// MS1, two connections of MS2, the parameter channel, and Set_Slave_Add.
const JOBS: usize = 5;

/// The answer to an access through a connection beyond the second.
const NO_ENTRY: Dpv1Error = Dpv1Error::new(ErrorCode::RESOURCE_UNAVAILABLE);

/// The device of the slave: tables, the last inputs, and the requests of masters. It computes nothing.
#[derive(Clone, Debug)]
pub struct BusSide {
    model: &'static Model,
    im0: Option<[u8; IM_RECORD_LENGTH]>,
    configuration: &'static Configuration,
    prm: Option<&'static UserPrm>,
    channel: ParameterChannel,
    channel_in: Option<usize>,
    channel_out: Option<usize>,
    tasks: Tasks,
    inputs: [u8; MAX_IMAGE],
    /// The inputs are those of this parameterisation.
    inputs_valid: bool,
    exchanging: bool,
    entries: [Entry; JOBS],
    /// The number of the last job.
    number: u8,
    /// The application has a job and has not finished it.
    application_is_busy: bool,
    address: u8,
    address_is_settable: bool,
    /// No_Add_Chg.
    address_is_locked: bool,
}

/// The access of one source.
#[derive(Clone, Copy, Debug)]
enum Entry {
    Free,
    /// The application does not have it yet.
    Waiting(Job),
    /// The application has the job of this number.
    Taken(u8),
    Done(Result<Octets, AccessError>),
}

impl Entry {
    const fn is_open(&self) -> bool {
        matches!(self, Self::Waiting(_) | Self::Taken(_))
    }
}

impl BusSide {
    /// The bus side of this device, which has just been switched on.
    #[must_use]
    pub fn new<B: Behaviour, S: Store>(device: &BlockDevice<B, S>) -> Self {
        let model = device.behaviour.model();
        let mut side = Self {
            model,
            im0: device.behaviour.im0(),
            configuration: model.default_configuration,
            prm: None,
            channel: ParameterChannel::new(model.channel_rules),
            channel_in: None,
            channel_out: None,
            tasks: Tasks {
                generation: 0,
                ended: false,
                user_prm: None,
                configuration: None,
                begun: false,
                changes: [None; MAX_CHANGES],
                commands: Commands::default(),
                job: None,
                channel_read: None,
            },
            inputs: [0; MAX_IMAGE],
            inputs_valid: true,
            exchanging: false,
            entries: [Entry::Free; JOBS],
            number: 0,
            application_is_busy: false,
            address: device.address.get(),
            address_is_settable: device.address.is_settable(),
            address_is_locked: device.address.is_locked(),
        };
        side.locate_channel();
        side
    }

    /// The station address.
    #[must_use]
    pub const fn address(&self) -> u8 {
        self.address
    }

    /// Data exchange runs.
    #[must_use]
    pub const fn is_exchanging(&self) -> bool {
        self.exchanging
    }

    /// Whether a master has requested something that [`take_tasks`](Self::take_tasks) has not returned yet.
    #[must_use]
    pub fn has_tasks(&self) -> bool {
        let Tasks { ended, begun, user_prm, configuration, changes: [change, ..], .. } = &self.tasks;
        let is_waiting = |entry: &Entry| matches!(entry, Entry::Waiting(_));
        let has_job = !self.application_is_busy && self.entries.iter().any(is_waiting);
        *ended || *begun || user_prm.is_some() || configuration.is_some() || change.is_some() || has_job
    }

    /// What masters have requested since the last call. The slave must not run during the call.
    #[must_use]
    pub fn take_tasks(&mut self) -> Tasks {
        self.tasks.channel_read = self.channel_read();
        self.tasks.job = if self.application_is_busy { None } else { self.next_job() };
        self.application_is_busy |= self.tasks.job.is_some();
        let tasks = self.tasks.clone();
        self.tasks.ended = false;
        self.tasks.begun = false;
        self.tasks.user_prm = None;
        self.tasks.configuration = None;
        self.tasks.changes = [None; MAX_CHANGES];
        tasks
    }

    /// Takes over the results of the application. The slave must not run during the call.
    pub fn publish(&mut self, snapshot: &Snapshot) {
        if snapshot.generation == self.tasks.generation {
            self.inputs = snapshot.inputs;
            self.inputs_valid = true;
        }
        self.application_is_busy = false;
        if snapshot.unlocked {
            self.address_is_locked = false;
        }
        if let Some((read, result)) = &snapshot.channel_read
            && self.channel_read() == Some(*read)
        {
            self.channel.set_result(result.as_deref().map_err(|error| *error));
        }
        if let Some(done) = snapshot.done {
            self.take_result(done);
        }
    }

    /// A result counts while its source waits for the job of this number.
    fn take_result(&mut self, done: Done) {
        let Some(entry) = position_of(done.via).and_then(|position| self.entries.get_mut(position)) else { return };
        if !matches!(entry, Entry::Taken(number) if *number == done.number) {
            return;
        }
        *entry = match done.via {
            Via::Relation(_) => Entry::Done(done.result),
            Via::Channel | Via::Address => Entry::Free,
        };
        // The master may have withdrawn the task of the channel.
        if done.via == Via::Channel && matches!(self.channel.task(), Some(Task::Write(_))) {
            self.channel.set_result(done.result.as_deref().map_err(|error| *error));
        }
    }

    fn channel_read(&self) -> Option<ChannelRead> {
        match self.channel.task() {
            Some(Task::Read { slot, index }) => Some((slot, index)),
            Some(Task::Write(_)) | None => None,
        }
    }

    /// The oldest job that waits.
    fn next_job(&mut self) -> Option<Job> {
        let age = |job: &Job, last: u8| last.wrapping_sub(job.number);
        let last = self.number;
        let mut oldest: Option<(&mut Entry, Job)> = None;
        for entry in &mut self.entries {
            if let Entry::Waiting(job) = *entry
                && oldest.as_ref().is_none_or(|(_, other)| age(&job, last) > age(other, last))
            {
                oldest = Some((entry, job));
            }
        }
        let (entry, job) = oldest?;
        *entry = Entry::Taken(job.number);
        Some(job)
    }

    fn add_job(&mut self, via: Via, access: Access) {
        self.number = self.number.wrapping_add(1);
        if let Some(entry) = position_of(via).and_then(|position| self.entries.get_mut(position)) {
            *entry = Entry::Waiting(Job { via, number: self.number, access });
        }
    }

    /// An access through a relation.
    fn add_access(&mut self, relation: Relation, access: Access) -> Result<(), Dpv1Error> {
        let via = Via::Relation(relation);
        position_of(via).ok_or(NO_ENTRY)?;
        self.add_job(via, access);
        Ok(())
    }

    fn entry(&self, via: Via) -> Entry {
        position_of(via).and_then(|position| self.entries.get(position)).copied().unwrap_or(Entry::Free)
    }

    fn locate_channel(&mut self) {
        self.channel_in = channel_offset(self.configuration.inputs);
        self.channel_out = channel_offset(self.configuration.outputs);
    }

    /// A task of the channel. A write that has begun is finished; until then the channel takes only its withdrawal.
    fn accept_channel_request(&mut self, octets: [u8; parameter_channel::OCTETS]) {
        let [first, ..] = octets;
        if first >> 4 != 0 && self.entry(Via::Channel).is_open() {
            return;
        }
        if let Some(write) = self.channel.accept(octets) {
            self.add_job(Via::Channel, Access::Channel(write));
        }
    }

    /// The outputs without the parameter channel. Where they change faster than the application runs, the oldest changes and the
    /// present outputs reach it.
    fn set_commands(&mut self, commands: Commands) {
        if commands == self.tasks.commands {
            return;
        }
        self.tasks.commands = commands;
        if let Some(free) = self.tasks.changes.iter_mut().find(|change| change.is_none()) {
            *free = Some(commands);
        }
    }

    /// The inputs of the present parameterisation are not there yet.
    fn begin_parameterisation(&mut self) {
        self.tasks.generation = self.tasks.generation.wrapping_add(1);
        self.inputs_valid = false;
    }
}

/// The first octet of the parameter channel.
fn channel_offset(telegram: Option<&'static Telegram>) -> Option<usize> {
    telegram?.layout().find(|(_, field)| *field == Field::ParameterChannel).map(|(offset, _)| offset)
}

/// The entry of a source. Connections beyond the second have none.
const fn position_of(via: Via) -> Option<usize> {
    Some(match via {
        Via::Relation(Relation::Ms1) => 0,
        Via::Relation(Relation::Ms2(0)) => 1,
        Via::Relation(Relation::Ms2(1)) => 2,
        Via::Relation(Relation::Ms2(_)) => return None,
        Via::Channel => 3,
        Via::Address => 4,
    })
}

impl Device for BusSide {
    fn ident_number(&self) -> u16 {
        self.model.ident
    }

    fn features(&self) -> Features {
        self.model.features
    }

    fn set_prm(&mut self, user: &[u8]) -> Result<(), PrmFault> {
        let prm = self.model.user_prm(user).ok_or(PrmFault)?;
        self.prm = Some(prm);
        self.tasks.user_prm = Some(prm);
        self.begin_parameterisation();
        Ok(())
    }

    fn chk_cfg(&mut self, cfg: &[u8]) -> Result<Lengths, CfgFault> {
        let configuration = self.model.configuration(cfg).ok_or(CfgFault)?;
        if !self.prm.is_some_and(|prm| self.model.fits(prm, configuration)) {
            return Err(CfgFault);
        }
        let octets = |octets| u8::try_from(octets).map_err(|_| CfgFault);
        let lengths =
            Lengths { outputs: octets(configuration.output_octets())?, inputs: octets(configuration.input_octets())? };
        self.configuration = configuration;
        self.channel = ParameterChannel::new(self.model.channel_rules);
        self.locate_channel();
        self.tasks.configuration = Some(configuration);
        self.begin_parameterisation();
        Ok(lengths)
    }

    fn get_cfg(&self) -> &[u8] {
        self.configuration.octets
    }

    /// An end after a beginning that the application has not seen leaves nothing to begin.
    fn set_exchanging(&mut self, running: bool) {
        self.tasks.ended |= !running;
        self.tasks.begun = running;
        self.exchanging = running;
    }

    fn outputs(&mut self, outputs: Outputs<'_>) {
        let Outputs::Data(image) = outputs else {
            self.accept_channel_request([0; parameter_channel::OCTETS]);
            let octets = self.configuration.output_octets();
            let channel = self.channel_out.map_or(0, |_| parameter_channel::OCTETS);
            return self.set_commands(Commands::zeros(octets.saturating_sub(channel)));
        };
        let Some(offset) = self.channel_out else { return self.set_commands(Commands::new(image)) };
        let Some((octets, rest)) = image.get(offset..).and_then(|octets| octets.split_first_chunk()) else { return };
        self.accept_channel_request(*octets);
        self.set_commands(Commands::new(rest));
    }

    fn inputs(&mut self, inputs: &mut [u8]) {
        let Some(image) = self.inputs.get(..inputs.len()) else { return };
        inputs.copy_from_slice(image);
        let target = self.channel_in.and_then(|offset| inputs.get_mut(offset..)).and_then(|at| at.first_chunk_mut());
        if let Some(target) = target {
            *target = *self.channel.answer();
        }
    }

    /// The inputs are those that the application has published last, but the answer in the parameter channel follows its task.
    #[cfg(feature = "prepared-answers")]
    fn keeps_inputs(&self, _before: &[u8], outputs: &[u8]) -> bool {
        let channel = |offset| outputs.get(offset..).and_then(|octets| octets.first_chunk());
        self.channel_out.is_none_or(|offset| channel(offset).is_some_and(|octets| self.channel.keeps(*octets)))
    }

    /// Stat_Diag until the application has the inputs of the present parameterisation.
    fn diagnosis(&self) -> Diagnosis<'_> {
        Diagnosis { static_diag: !self.inputs_valid, ..Diagnosis::default() }
    }

    fn address_is_settable(&self) -> bool {
        self.address_is_settable
    }

    /// chosen: the address is valid at once and stored afterwards, because the acknowledgement says only that the request
    /// has arrived.
    fn set_address(&mut self, request: &SetSlaveAdd<'_>) -> Option<u8> {
        let locked = request.no_add_chg != 0;
        if !self.address_is_settable || self.address_is_locked || self.entry(Via::Address).is_open() {
            return None;
        }
        self.address = request.address;
        self.address_is_locked = locked;
        self.add_job(Via::Address, Access::Address { address: request.address, locked });
        Some(request.address)
    }

    fn im0(&self) -> Option<[u8; IM_RECORD_LENGTH]> {
        self.im0
    }

    fn read(&mut self, via: Relation, slot: u8, index: u8, _record: &mut [u8]) -> Result<usize, Dpv1Error> {
        self.add_access(via, Access::Read { via, slot, index })?;
        Ok(0)
    }

    fn write(&mut self, via: Relation, slot: u8, index: u8, record: &[u8]) -> Result<(), Dpv1Error> {
        self.add_access(via, Access::Write { via, slot, index, record: Record::new(record) })
    }

    fn is_executing(&self, via: Relation) -> bool {
        self.entry(Via::Relation(via)).is_open()
    }

    fn complete(&mut self, via: Relation, record: &mut [u8]) -> Result<usize, Dpv1Error> {
        let via = Via::Relation(via);
        let Entry::Done(result) = self.entry(via) else { return Err(Dpv1Error::STATE_CONFLICT) };
        if let Some(entry) = position_of(via).and_then(|position| self.entries.get_mut(position)) {
            *entry = Entry::Free;
        }
        let octets = result?;
        record.get_mut(..octets.len()).ok_or(AccessError::WrongLength)?.copy_from_slice(&octets);
        Ok(octets.len())
    }
}
