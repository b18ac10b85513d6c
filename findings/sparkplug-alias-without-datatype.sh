#!/usr/bin/env bash
# sparkplug-payload 1.0.3 (npm), pysparkplug 0.6.1, mqtt-spb-wrapper 2.1.2: no value from data with an alias.
#
# Expected: the birth names a metric, gives it an alias and a data type; data then has the alias and no name
# (Sparkplug 3.0.0, tck-id-payloads-alias-data-cmd-requirement) and should have no data type (tck-id-payloads-metric-datatype-not-req).
# The value stands in double_value, a field of its own in the protobuf message, so a decoder that knows no birth can read it, too.
#
# Seen: three libraries fail in three ways. sparkplug-payload decodes the metric with value null, as if the sensor had none. pysparkplug
# raises NotImplementedError, also for the octets that its own DData.encode() writes. mqtt-spb-wrapper, which has seen the birth, keeps the
# value of the birth as the present one.
#
# Why it matters: a gateway that keeps to "must" and "should" is unreadable for them. With the last one a dashboard shows the pressure of
# the connection's start for ever. An edge node that has to serve them sends name and data type with all data.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv one
python3 -m venv two # the two need different versions of protobuf
one/bin/pip install --quiet --disable-pip-version-check pysparkplug==0.6.1 protobuf==7.36.2
two/bin/pip install --quiet --disable-pip-version-check mqtt-spb-wrapper==2.1.2 protobuf==3.20.3
npm install --silent --ignore-scripts --no-audit --no-fund sparkplug-payload@1.0.3 >&2

# "DATA/Pressure", alias 7, Double, 5e-9 in the birth; alias 7, 6e-9 in the data.
birth=0801121e0a0d444154412f507265737375726510071801200a693a8c30e28e79353e1801
data=0802120d1007180269df413adc11c5393e1802

check() { # library, seen, expected
    printf '%s: %s\n' "$1" "$2"
    if [ "$2" != "$3" ]; then
        echo "$1 changed: it was $3" >&2
        exit 1
    fi
}

# shellcheck disable=SC2016 # the code is JavaScript
seen=$(node -e '
    const [birth, data] = process.argv.slice(1).map((hex) =>
        require("sparkplug-payload").get("spBv1.0").decodePayload(Buffer.from(hex, "hex")).metrics[0].value);
    console.log(`birth ${birth}, data ${data}`);' "$birth" "$data")
check sparkplug-payload "$seen" 'birth 5e-9, data null'

seen=$(one/bin/python - "$birth" "$data" <<'PYTHON'
import sys
import pysparkplug as spb

birth, data = map(bytes.fromhex, sys.argv[1:])
own = spb.DData(timestamp=2, seq=2, metrics=(spb.Metric(timestamp=2, name=None, alias=7, datatype=spb.DataType.DOUBLE, value=6e-9),))
print("birth", spb.DBirth.decode(birth).metrics[0].value, end="")
for octets in (data, own.encode()):
    try:
        print(", data", spb.DData.decode(octets).metrics[0].value, end="")
    except NotImplementedError as error:
        print(f", data {error}", end="")
PYTHON
)
check pysparkplug "$seen" 'birth 5e-09, data UNKNOWN not implemented, data UNKNOWN not implemented'

seen=$(two/bin/python - "$birth" "$data" <<'PYTHON'
import sys
from mqtt_spb_wrapper import MqttSpbEntityDevice

birth, data = map(bytes.fromhex, sys.argv[1:])
device = MqttSpbEntityDevice("group", "node", "gauge")
device.deserialize_payload_birth(birth)
device.deserialize_payload_data(data)
print("after the data", device.data.get_value("Pressure"))
PYTHON
)
check mqtt-spb-wrapper "$seen" 'after the data 5e-09'
echo 'as described: none of the three reads data with an alias and without a data type'
