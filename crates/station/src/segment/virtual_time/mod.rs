//! Tests of a segment in virtual time: stalls of the bus, a port that is lost, a clock that is set, gauges that do not answer, the search
//! of a baud rate. No test waits, and none depends on the load of the computer.

mod fixture;
mod heard;
mod plant;
mod polled;
mod slaves;
mod test_slave;
