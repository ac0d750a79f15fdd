"""Creates a keystore with the layout of `ros2 security`, without ROS.

The keystore is for the domain given by ROS_DOMAIN_ID. It has its own certificate authority, and an
enclave with permissions for each enclave of a policy. Only the part of the policy language that
evac.policy.xml uses is supported: ALLOW for topics and services. In addition to governance.p7s,
there is unguarded.p7s, which disables access control: a participant that uses it instead does not
enforce its own permissions.
"""

import argparse
import os
from collections.abc import Iterator
from datetime import datetime, timedelta, timezone
from pathlib import Path
from xml.etree import ElementTree

from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import (
    Encoding,
    NoEncryption,
    PrivateFormat,
    pkcs7,
)
from cryptography.x509.oid import NameOID

NOW = datetime.now(timezone.utc).replace(microsecond=0)
BEGIN, END = NOW - timedelta(days=1), NOW + timedelta(days=1)
SCHEMAS = "http://www.omg.org/spec/DDS-SECURITY/20170901"

# The same rules as `ros2 security create_keystore` writes, if {guarded} is "true".
GOVERNANCE = """\
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
     xsi:noNamespaceSchemaLocation="{schemas}/omg_shared_ca_governance.xsd">
  <domain_access_rules>
    <domain_rule>
      <domains><id>{domain_id}</id></domains>
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>SIGN</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>{guarded}</enable_read_access_control>
          <enable_write_access_control>{guarded}</enable_write_access_control>
          <metadata_protection_kind>ENCRYPT</metadata_protection_kind>
          <data_protection_kind>ENCRYPT</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
"""

PERMISSIONS = """\
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
     xsi:noNamespaceSchemaLocation="{schemas}/omg_shared_ca_permissions.xsd">
  <permissions>
    <grant name="{name}">
      <subject_name>CN={name}</subject_name>
      <validity>
        <not_before>{begin:%Y-%m-%dT%H:%M:%S}</not_before>
        <not_after>{end:%Y-%m-%dT%H:%M:%S}</not_after>
      </validity>
      <allow_rule>
        <domains><id>{domain_id}</id></domains>
        <publish><topics>{publish}</topics></publish>
        <subscribe><topics>{subscribe}</topics></subscribe>
      </allow_rule>
      <default>DENY</default>
    </grant>
  </permissions>
</dds>
"""


class Identity:
    """A private key and its certificate, self-signed if there is no issuer."""

    def __init__(self, name: str, issuer: "Identity | None" = None) -> None:
        self.name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])
        self.key = ec.generate_private_key(ec.SECP256R1())
        is_authority = issuer is None
        length = 1 if is_authority else None
        self.certificate = (
            x509.CertificateBuilder()
            .subject_name(self.name)
            .issuer_name((issuer or self).name)
            .public_key(self.key.public_key())
            .serial_number(x509.random_serial_number())
            .not_valid_before(BEGIN)
            .not_valid_after(END)
            .add_extension(x509.BasicConstraints(is_authority, length), critical=is_authority)
            .sign((issuer or self).key, hashes.SHA256())
        )

    def write(self, certificate: Path, key: Path) -> None:
        """Writes the certificate and the key as PEM."""
        certificate.write_bytes(self.certificate.public_bytes(Encoding.PEM))
        pem = self.key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
        key.write_bytes(pem)

    def sign(self, text: str) -> bytes:
        """Returns the text and its signature as S/MIME."""
        builder = pkcs7.PKCS7SignatureBuilder().set_data(text.encode())
        builder = builder.add_signer(self.certificate, self.key, hashes.SHA256())
        options = [pkcs7.PKCS7Options.Text, pkcs7.PKCS7Options.DetachedSignature]
        return builder.sign(Encoding.SMIME, options)


def absolute(profile: ElementTree.Element, name: str) -> str:
    """Returns the fully qualified name of a topic or service that a profile names."""
    namespace = profile.attrib["ns"].rstrip("/")
    if name.startswith("/"):
        return name
    if name.startswith("~"):
        return f"{namespace}/{profile.attrib['node']}{name[1:]}"
    return f"{namespace}/{name}"


def topics(enclave: ElementTree.Element, direction: str) -> Iterator[str]:
    """Yields the DDS topics that an enclave may use in a direction: "publish" or "subscribe"."""
    # Maps nodes to participants; every ROS 2 node needs it.
    yield "ros_discovery_info"
    client, server = ("request", "reply") if direction == "publish" else ("reply", "request")
    for profile in enclave.iter("profile"):
        for group in profile:
            names = [absolute(profile, item.text) for item in group]
            if group.attrib.get(direction) == "ALLOW":
                yield from (f"rt{name}" for name in names)
            if group.attrib.get(client) == "ALLOW":
                yield from (f"rq{name}Request" for name in names)
            if group.attrib.get(server) == "ALLOW":
                yield from (f"rr{name}Reply" for name in names)


def link(directory: Path, target: Path, name: str) -> None:
    """Creates a relative link `name` to a file in the keystore."""
    (directory / name).symlink_to(os.path.relpath(target, directory))


def main() -> None:
    """Parses the arguments and creates the keystore."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--policy", type=Path, required=True, help="an SROS2 policy file")
    parser.add_argument("keystore", type=Path, help="the directory to create")
    arguments = parser.parse_args()

    domain_id = os.environ.get("ROS_DOMAIN_ID", "0")
    keystore = arguments.keystore
    public, private, enclaves = (keystore / name for name in ("public", "private", "enclaves"))
    for directory in (public, private, enclaves):
        directory.mkdir(parents=True)
    authority = Identity("sros2CA")
    authority.write(public / "ca.cert.pem", private / "ca.key.pem")
    for role in ("identity_ca", "permissions_ca"):
        link(public, public / "ca.cert.pem", f"{role}.cert.pem")
        link(private, private / "ca.key.pem", f"{role}.key.pem")
    for name, guarded in (("governance", "true"), ("unguarded", "false")):
        text = GOVERNANCE.format(schemas=SCHEMAS, domain_id=domain_id, guarded=guarded)
        (enclaves / f"{name}.p7s").write_bytes(authority.sign(text))

    for enclave in ElementTree.parse(arguments.policy).iter("enclave"):
        name = enclave.attrib["path"]
        directory = enclaves / name.lstrip("/")
        directory.mkdir(parents=True)
        for role in ("identity_ca", "permissions_ca"):
            link(directory, public / f"{role}.cert.pem", f"{role}.cert.pem")
        link(directory, enclaves / "governance.p7s", "governance.p7s")
        Identity(name, authority).write(directory / "cert.pem", directory / "key.pem")
        allowed = {
            direction: "".join(f"<topic>{topic}</topic>" for topic in topics(enclave, direction))
            for direction in ("publish", "subscribe")
        }
        text = PERMISSIONS.format(
            schemas=SCHEMAS, domain_id=domain_id, name=name, begin=BEGIN, end=END, **allowed
        )
        (directory / "permissions.p7s").write_bytes(authority.sign(text))


if __name__ == "__main__":
    main()
