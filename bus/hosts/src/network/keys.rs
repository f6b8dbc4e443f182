//! Certificates of a run across hosts: an authority of its own, and one certificate for all hosts.

use std::fs::{DirBuilder, OpenOptions};
use std::io::{self, Write as _};
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::Path;

use rcgen::{
    BasicConstraints, CertificateParams, ExtendedKeyUsagePurpose, IsCa, Issuer, KeyPair,
    KeyUsagePurpose, date_time_ymd,
};

/// The certificate of the authority.
pub(crate) const AUTHORITY: &str = "authority.pem";
/// The certificate of the hosts.
pub(crate) const CERTIFICATE: &str = "certificate.pem";
/// The private key of the hosts.
pub(crate) const KEY: &str = "key.pem";

/// Makes the certificates in a new folder. They are valid until the end of the day (year, month, day). The key of the
/// authority is not kept: nobody can make another certificate.
///
/// # Errors
/// The folder exists, or cannot be written.
pub fn make(folder: &Path, until: (i32, u8, u8)) -> io::Result<()> {
    let (authority, certificate, key) = certificates(until).map_err(io::Error::other)?;
    DirBuilder::new().mode(0o700).create(folder)?;
    for (name, text) in [
        (AUTHORITY, authority),
        (CERTIFICATE, certificate),
        (KEY, key),
    ] {
        let mut options = OpenOptions::new();
        let mut file = options
            .write(true)
            .create_new(true)
            .mode(0o600)
            .open(folder.join(name))?;
        file.write_all(text.as_bytes())?;
    }
    Ok(())
}

fn certificates(until: (i32, u8, u8)) -> Result<(String, String, String), rcgen::Error> {
    let (year, month, day) = until;
    let mut authority = CertificateParams::new(Vec::new())?;
    authority.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
    authority.key_usages = vec![KeyUsagePurpose::KeyCertSign];
    authority.not_after = date_time_ymd(year, month, day);
    let authority_key = KeyPair::generate()?;
    let own = authority.self_signed(&authority_key)?;
    let mut host = CertificateParams::new(vec!["slipstream".to_owned()])?;
    host.not_after = date_time_ymd(year, month, day);
    host.extended_key_usages = vec![
        ExtendedKeyUsagePurpose::ServerAuth,
        ExtendedKeyUsagePurpose::ClientAuth,
    ];
    let key = KeyPair::generate()?;
    let issuer = Issuer::new(authority, authority_key);
    let certificate = host.signed_by(&key, &issuer)?;
    Ok((own.pem(), certificate.pem(), key.serialize_pem()))
}
