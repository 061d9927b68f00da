//! A CAN bus, event by event in bit times.
