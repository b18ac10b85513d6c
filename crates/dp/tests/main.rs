//! The tests of slave and master in one program: linked once, and what they share is compiled once.

#[path = "../../../tests/support/every_file.rs"]
mod every_file;
#[path = "../../../tests/support/golden.rs"]
mod golden;
#[path = "../../../tests/support/octets.rs"]
mod octets;
#[path = "wrong_answers/main.rs"]
mod wrong_answers;

mod acyclic_dialogues;
mod acyclic_fuzz;
mod acyclic_line;
mod acyclic_wrong;
mod address;
mod any_order;
mod bring_up;
mod conformance;
mod control;
mod cycle_time;
mod cyclic;
mod errors;
mod exchange;
mod fdl;
mod frame_count;
mod fuzz;
mod im0;
mod matrix;
mod message_cycle;
mod ms1;
mod ms2;
mod ms2_master;
mod ms2_search;
mod ms2_timers;
mod no_panic;
mod persistent;
mod pkw_master;
mod prepared_answer;
mod rate;
mod raw_requests;
mod receiver;
mod rig;
mod ring;
mod size;
mod slave_list;
mod start_up;
mod support;
mod watchdog;
