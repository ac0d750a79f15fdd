"""Makes a keystore as `ros2 security` lays it out, for the domain of ROS_DOMAIN_ID, without ROS.

It has an authority of its own, and an enclave for each of a policy, with the permissions that the
policy allows. Of the policy language it knows what evac.policy.xml uses: what is allowed, by topics
and services. Beside governance.p7s there is unguarded.p7s, in which nobody's permissions count: with
it in the other's place, a participant stops at nothing of its own accord.
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
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat, pkcs7
from cryptography.x509.oid import NameOID

NOW = datetime.now(timezone.utc).replace(microsecond=0)
BEGIN, END = NOW - timedelta(days=1), NOW + timedelta(days=1)
SCHEMAS = "http://www.omg.org/spec/DDS-SECURITY/20170901"

# As `ros2 security create_keystore` has it.
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
    """A key, and the certificate that says whose it is."""

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
        """Writes both as PEM."""
        certificate.write_bytes(self.certificate.public_bytes(Encoding.PEM))
        pem = self.key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
        key.write_bytes(pem)

    def sign(self, text: str) -> bytes:
        """The text with a signature, as S/MIME."""
        builder = pkcs7.PKCS7SignatureBuilder().set_data(text.encode())
        builder = builder.add_signer(self.certificate, self.key, hashes.SHA256())
        options = [pkcs7.PKCS7Options.Text, pkcs7.PKCS7Options.DetachedSignature]
        return builder.sign(Encoding.SMIME, options)


def absolute(profile: ElementTree.Element, name: str) -> str:
    """A name of a profile's node, without its namespace if it has none."""
    namespace = profile.attrib["ns"].rstrip("/")
    if name.startswith("/"):
        return name
    if name.startswith("~"):
        return f"{namespace}/{profile.attrib['node']}{name[1:]}"
    return f"{namespace}/{name}"


def topics(enclave: ElementTree.Element, direction: str) -> Iterator[str]:
    """The topics of DDS that an enclave may publish or subscribe to."""
    # What tells which node is of which participant.
    yield "ros_discovery_info"
    asked, answered = ("request", "reply") if direction == "publish" else ("reply", "request")
    for profile in enclave.iter("profile"):
        for group in profile:
            names = [absolute(profile, item.text) for item in group]
            if group.attrib.get(direction) == "ALLOW":
                yield from (f"rt{name}" for name in names)
            if group.attrib.get(asked) == "ALLOW":
                yield from (f"rq{name}Request" for name in names)
            if group.attrib.get(answered) == "ALLOW":
                yield from (f"rr{name}Reply" for name in names)


def link(directory: Path, target: Path, name: str) -> None:
    """A link to what the keystore has once."""
    (directory / name).symlink_to(os.path.relpath(target, directory))


def main() -> None:
    """Makes a keystore as the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--policy", type=Path, required=True, help="a policy file of SROS2")
    parser.add_argument("keystore", type=Path, help="its directory, which there is not yet")
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
