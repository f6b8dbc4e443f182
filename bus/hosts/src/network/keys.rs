//! Certificates of a run across hosts: an authority of its own, and one certificate for all hosts.

use std::fs::{self, DirBuilder, OpenOptions};
use std::io::{self, Write as _};
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use rcgen::{
    BasicConstraints, CertificateParams, ExtendedKeyUsagePurpose, IsCa, Issuer, KeyPair,
    KeyUsagePurpose,
};
use slipstream_bus::InputError;

/// The certificate of the authority.
pub(super) const AUTHORITY: &str = "authority.pem";
/// The certificate of the hosts.
pub(super) const CERTIFICATE: &str = "certificate.pem";
/// The private key of the hosts.
pub(super) const KEY: &str = "key.pem";
/// Until when they are valid (s since 1970).
const VALID_UNTIL: &str = "valid-until";

const DAY: Duration = Duration::from_secs(24 * 3600);

/// Makes certificates that are valid for so many days in a new folder. The key of the authority is not kept: nobody
/// can make another certificate.
///
/// # Errors
/// The folder exists, or cannot be written.
pub fn make(folder: &Path, days: u32) -> Result<(), InputError> {
    let unwritable = |error: io::Error| {
        let problem = format!("cannot be made: {error}");
        InputError::new(folder.display().to_string(), problem, "give another folder")
    };
    let until = SystemTime::now() + days * DAY;
    let texts = certificates(until).map_err(|error| unwritable(io::Error::other(error)))?;
    let made = DirBuilder::new().mode(0o700).create(folder);
    let names = [AUTHORITY, CERTIFICATE, KEY, VALID_UNTIL];
    let mut files = names.iter().zip(&texts);
    made.and_then(|()| files.try_for_each(|(name, text)| write(&folder.join(name), text)))
        .map_err(unwritable)
}

/// Checks that a folder has certificates that are still valid.
///
/// # Errors
/// A file is missing, or the certificates have expired.
pub fn check(folder: &Path) -> Result<(), InputError> {
    let invalid = |problem: String, remedy: &str| {
        InputError::new(format!("--tls {}", folder.display()), problem, remedy)
    };
    for name in [AUTHORITY, CERTIFICATE, KEY] {
        if let Err(error) = fs::File::open(folder.join(name)) {
            let problem = format!("has no {name} that can be read: {error}");
            return Err(invalid(
                problem,
                "make a folder with slipstream keys, and copy all of it",
            ));
        }
    }
    let until = fs::read_to_string(folder.join(VALID_UNTIL)).unwrap_or_default();
    let until: Option<u64> = until.trim().parse().ok();
    let since = until.and_then(|until| {
        let until = UNIX_EPOCH + Duration::from_secs(until);
        SystemTime::now().duration_since(until).ok()
    });
    match since {
        None => Ok(()),
        Some(since) => {
            let days = since.as_secs() / DAY.as_secs();
            let problem = format!("has certificates that expired {days} days ago");
            Err(invalid(
                problem,
                "make new ones with slipstream keys, or set the clock of this computer",
            ))
        }
    }
}

fn write(path: &Path, text: &str) -> io::Result<()> {
    let mut options = OpenOptions::new();
    let mut file = options
        .write(true)
        .create_new(true)
        .mode(0o600)
        .open(path)?;
    file.write_all(text.as_bytes())
}

/// Authority, certificate, key, and until when they are valid.
fn certificates(until: SystemTime) -> Result<[String; 4], rcgen::Error> {
    let mut authority = CertificateParams::new(Vec::new())?;
    authority.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
    authority.key_usages = vec![KeyUsagePurpose::KeyCertSign];
    authority.not_after = until.into();
    let authority_key = KeyPair::generate()?;
    let own = authority.self_signed(&authority_key)?;
    let mut host = CertificateParams::new(vec!["slipstream".to_owned()])?;
    host.not_after = until.into();
    host.extended_key_usages = vec![
        ExtendedKeyUsagePurpose::ServerAuth,
        ExtendedKeyUsagePurpose::ClientAuth,
    ];
    let key = KeyPair::generate()?;
    let certificate = host.signed_by(&key, &Issuer::new(authority, authority_key))?;
    let seconds = until
        .duration_since(UNIX_EPOCH)
        .map_or(0, |since| since.as_secs());
    Ok([
        own.pem(),
        certificate.pem(),
        key.serialize_pem(),
        seconds.to_string(),
    ])
}
