//! A plant from its record: how a record is cut into phases, what the numbers mean in words, and what the API shows.
//!
//! The fit itself is `profivac_identify::plant`. The command `profivac identify` and the dashboard share this module.
//!
//! | Module | Holds |
//! |---|---|
//! | [`record`] | the record of a fit, from samples and what the user knows |
//! | [`words`] | how certain a number is, and remedies, as sentences |
//! | [`view`] | what the API shows |

pub mod record;
pub mod view;
pub mod words;
