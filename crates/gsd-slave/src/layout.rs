//! Which octet of the inputs and outputs belongs to which module.

use profivac_gsd::Plugged;
use profivac_wire::cfg::{self, Identifiers};
use std::fmt;
use std::ops::Range;

/// The direction of data, as the master sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Direction {
    /// Slave to master.
    Input,
    /// Master to slave.
    Output,
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Input => "input",
            Self::Output => "output",
        })
    }
}

/// The modules of a configuration and their places in the inputs and outputs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    /// The modules by slot.
    pub modules: Vec<PlacedModule>,
}

/// A module in its slot, with its data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlacedModule {
    /// The number of the slot.
    pub slot: u32,
    /// The number of the module in the file.
    pub number: u32,
    /// Its name in the file.
    pub name: String,
    /// Its configuration octets.
    pub config: Vec<u8>,
    /// Its identifiers within Chk_Cfg, counted from 0 as diagnosis counts them. A module has none, one or several.
    pub identifiers: Range<usize>,
    /// Its inputs and outputs, in the order of its identifiers.
    pub areas: Vec<Area>,
}

/// Octets of one identifier in one direction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Area {
    /// The direction.
    pub direction: Direction,
    /// The identifier within Chk_Cfg, from 0.
    pub identifier: usize,
    /// Octets within all inputs or outputs of the slave.
    pub range: Range<usize>,
    /// Whether a unit is a word of two octets.
    pub words: bool,
    /// Whether all octets are consistent, instead of each unit.
    pub consistent: bool,
}

/// A module with data in one direction, see [`Layout::inputs`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModuleData<'a> {
    /// The module.
    pub module: &'a PlacedModule,
    /// Where its octets start within all inputs or outputs of the slave.
    pub start: usize,
    /// Number of octets.
    pub octets: usize,
}

impl ModuleData<'_> {
    /// `slot 2 4DO`.
    #[must_use]
    pub fn name(&self) -> String {
        self.module.label()
    }

    /// The octets of the module, none if the image is too short.
    #[must_use]
    pub fn of<'i>(&self, image: &'i [u8]) -> Option<&'i [u8]> {
        image.get(self.start..self.start.checked_add(self.octets)?)
    }
}

impl PlacedModule {
    /// `slot 2 4DO`.
    #[must_use]
    pub fn label(&self) -> String {
        format!("slot {} {}", self.slot, self.name)
    }

    /// The module's octets in one direction: they are together, because the identifiers of a module are.
    #[must_use]
    pub fn data(&self, direction: Direction) -> Option<ModuleData<'_>> {
        let mut areas = self.areas.iter().filter(|area| area.direction == direction);
        let first = areas.next()?;
        let end = areas.next_back().unwrap_or(first).range.end;
        Some(ModuleData { module: self, start: first.range.start, octets: end.saturating_sub(first.range.start) })
    }
}

impl Layout {
    pub(crate) fn new(plugged: &[Plugged<'_>]) -> Self {
        let mut next = Next::default();
        Self { modules: plugged.iter().map(|one| next.module(one)).collect() }
    }

    /// The modules with inputs, in the order of their octets.
    pub fn inputs(&self) -> impl Iterator<Item = ModuleData<'_>> {
        self.data(Direction::Input)
    }

    /// The modules with outputs, in the order of their octets.
    pub fn outputs(&self) -> impl Iterator<Item = ModuleData<'_>> {
        self.data(Direction::Output)
    }

    /// The modules with data in this direction, in the order of their octets.
    pub fn data(&self, direction: Direction) -> impl Iterator<Item = ModuleData<'_>> {
        self.modules.iter().filter_map(move |module| module.data(direction))
    }

    /// The name of an octet of the inputs or outputs: `slot 3 4DO octet 0`, with the octet counted within the module. None beyond the
    /// last octet.
    #[must_use]
    pub fn name_of(&self, direction: Direction, octet: usize) -> Option<String> {
        let found = self.data(direction).find_map(|data| {
            let within = octet.checked_sub(data.start)?;
            (within < data.octets).then(|| (data.name(), within))
        });
        found.map(|(module, octet)| format!("{module} octet {octet}"))
    }

    /// The module of an identifier of Chk_Cfg, counted from 0 as diagnosis counts them.
    #[must_use]
    pub fn module_of_identifier(&self, identifier: usize) -> Option<&PlacedModule> {
        self.modules.iter().find(|module| module.identifiers.contains(&identifier))
    }

    /// The module in a slot.
    #[must_use]
    pub fn in_slot(&self, slot: u32) -> Option<&PlacedModule> {
        self.modules.iter().find(|module| module.slot == slot)
    }
}

/// The next identifier and the next octet in each direction.
#[derive(Default)]
struct Next {
    identifier: usize,
    input: usize,
    output: usize,
}

impl Next {
    fn module(&mut self, plugged: &Plugged<'_>) -> PlacedModule {
        let first = self.identifier;
        let mut areas = Vec::new();
        for identifier in Identifiers::new(&plugged.module.config).flatten() {
            let ways = [(Direction::Output, identifier.output), (Direction::Input, identifier.input)];
            areas.extend(ways.into_iter().filter_map(|(direction, area)| Some(self.area(direction, area?))));
            self.identifier = self.identifier.saturating_add(1);
        }
        PlacedModule {
            slot: plugged.slot,
            number: plugged.module.number,
            name: plugged.module.name.clone(),
            config: plugged.module.config.clone(),
            identifiers: first..self.identifier,
            areas,
        }
    }

    fn area(&mut self, direction: Direction, area: cfg::Area) -> Area {
        let next = match direction {
            Direction::Input => &mut self.input,
            Direction::Output => &mut self.output,
        };
        let start = *next;
        *next = next.saturating_add(usize::from(area.octets()));
        Area {
            direction,
            identifier: self.identifier,
            range: start..*next,
            words: area.words,
            consistent: area.consistent,
        }
    }
}
