//! Where a viewer listens: `host` or `host:port`, an IPv6 address in brackets.

use std::fmt;
use std::io::{self, ErrorKind};
use std::net::{Ipv6Addr, TcpStream, ToSocketAddrs};
use std::time::Duration;

/// TCP port on which tev listens unless it is told otherwise.
pub const DEFAULT_PORT: u16 = 14158;

/// An address that names no viewer.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BadAddress {
    /// Nothing stands where the host should.
    NoHost { address: String },
    /// The host has characters that no name of a host has.
    Host { address: String },
    /// What follows the colon is not 1 to 65535.
    Port { address: String },
    /// Too many colons, or brackets around something else than an IPv6 address.
    Colons { address: String },
}

impl fmt::Display for BadAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BadAddress::NoHost { address } => {
                write!(f, "viewer `{address}`: no host; write host or host:port, for example localhost:{DEFAULT_PORT}")
            }
            BadAddress::Host { address } => {
                write!(f, "viewer `{address}`: not the name of a host; write host or host:port, for example localhost")
            }
            BadAddress::Port { address } => write!(
                f,
                "viewer `{address}`: not a port; write a number from 1 to 65535 after the colon, or leave both out for \
                 {DEFAULT_PORT}"
            ),
            BadAddress::Colons { address } => {
                write!(f, "viewer `{address}`: write host:port, with an IPv6 address in brackets: [::1]:{DEFAULT_PORT}")
            }
        }
    }
}

impl std::error::Error for BadAddress {}

/// Where a viewer listens.
#[derive(Debug)]
pub(super) struct Address {
    /// A name or an IP address, without brackets.
    host: String,
    port: u16,
}

impl Address {
    pub fn parse(text: &str) -> Result<Address, BadAddress> {
        let address = || text.to_owned();
        let (host, port) = split(text).ok_or_else(|| BadAddress::Colons { address: address() })?;
        if host.is_empty() {
            return Err(BadAddress::NoHost { address: address() });
        }
        let in_names = |c: char| c.is_alphanumeric() || "-._".contains(c);
        if !text.starts_with('[') && !host.chars().all(in_names) {
            return Err(BadAddress::Host { address: address() });
        }
        let port =
            port.map_or(Some(DEFAULT_PORT), port_number).ok_or_else(|| BadAddress::Port { address: address() })?;
        Ok(Address { host: host.to_owned(), port })
    }

    /// Connects to the first of the host's addresses that answers within `timeout` (each).
    ///
    /// # Errors
    /// None does, and then why the last did not; or the name stands for none.
    pub fn connect(&self, timeout: Duration) -> io::Result<TcpStream> {
        let mut failure = io::Error::new(ErrorKind::NotFound, "the host has no address");
        for address in (self.host.as_str(), self.port).to_socket_addrs()? {
            match TcpStream::connect_timeout(&address, timeout) {
                Ok(stream) => return Ok(stream),
                Err(e) => failure = e,
            }
        }
        Err(failure)
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Address { host, port } = self;
        if host.contains(':') { write!(f, "[{host}]:{port}") } else { write!(f, "{host}:{port}") }
    }
}

/// Host and port, if the colons and brackets stand where they should.
fn split(text: &str) -> Option<(&str, Option<&str>)> {
    let (host, rest) = match text.strip_prefix('[') {
        Some(bracketed) => {
            let (host, rest) = bracketed.split_once(']')?;
            // What follows a % names the network interface.
            host.split('%').next()?.parse::<Ipv6Addr>().ok()?;
            (host, rest)
        }
        None => text.split_at(text.find(':').unwrap_or(text.len())),
    };
    if rest.is_empty() {
        return Some((host, None));
    }
    rest.strip_prefix(':').filter(|port| !port.contains(':')).map(|port| (host, Some(port)))
}

fn port_number(text: &str) -> Option<u16> {
    // The parser of numbers would take a sign.
    let digits = text.bytes().all(|b| b.is_ascii_digit());
    text.parse().ok().filter(|&port| digits && port != 0)
}
