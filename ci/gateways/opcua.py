#!/usr/bin/env python3
"""asyncua and node-opcua against the OPC UA gateway: ci/gateways/opcua.py PROGRAM

node-opcua is in ci/gateways/node-opcua, after `npm ci` there.
"""

import asyncio
import csv
import datetime
import io
import json
import logging
import os
import shutil
import subprocess
import sys
import time
import urllib.request

from asyncua import Client, ua
from asyncua.crypto.cert_gen import setup_self_signed_certificate
from asyncua.crypto.security_policies import SecurityPolicyBasic256Sha256
from cryptography.x509.oid import ExtendedKeyUsageOID
from plant import HANG_S, POLL_S, Hostile, Line, Plant, SlavePlant, free_port

logging.disable(logging.CRITICAL)
NAMESPACE = "urn:profivac:station"
PASSWORD = "tin whisker plateau"
HELLO = b"HELF" + (32).to_bytes(4, "little") + bytes(4) + b"\xff\xff\x00\x00" * 2 + bytes(8)
HOSTILE = [
    b"HELF\xff\xff\xff\xff" + bytes(100),
    b"HELF\x08\x00\x00\x00",
    HELLO + b"OPNF\xff\xff\xff\x7f" + bytes(500),
    HELLO + b"MSGF" + (64).to_bytes(4, "little") + b"\xff" * 56,
    HELLO + b"OPNF" + (132).to_bytes(4, "little") + bytes(4) + b"\xff\xff\xff\x7f" + bytes(120),
]


async def until(what, condition):
    """Returns the first true value of `await condition()`."""
    end, last = time.monotonic() + HANG_S, None
    while time.monotonic() < end:
        try:
            value = await condition()
            if value:
                return value
        except (OSError, ua.UaError, asyncio.TimeoutError) as error:
            last = error
        await asyncio.sleep(POLL_S)
    raise SystemExit(f"{what} did not happen within {HANG_S} s; last error: {last!r}")


class Changes:
    """The values of a subscription, in their order."""

    def __init__(self):
        self.values = []

    def datachange_notification(self, _node, value, _data):
        self.values.append(value)


class Station:
    """A connection without encryption, and the nodes of the station in it."""

    def __init__(self, port, client=None):
        self.client = client or Client(f"opc.tcp://127.0.0.1:{port}/", timeout=HANG_S, watchdog_intervall=HANG_S)

    async def __aenter__(self):
        await self.client.connect()
        self.namespace = await self.client.get_namespace_index(NAMESPACE)
        return self

    async def __aexit__(self, *_):
        await self.client.disconnect()

    def node(self, name):
        return self.client.get_node(ua.NodeId(name, self.namespace))

    async def data(self, name):
        return await self.node(name).read_data_value(raise_on_bad_status=False)

    async def value(self, name):
        return (await self.data(name)).Value.Value

    async def status(self, name):
        return (await self.data(name)).StatusCode.name

    async def property(self, name, wanted):
        return await (await self.node(name).get_child(f"0:{wanted}")).read_value()


async def connected(port):
    async def connect():
        station = Station(port)
        await station.__aenter__()
        return station
    return await until("a connection", connect)


async def browse(client):
    """All nodes below Objects; each must answer for its class and, as a variable, for value, type and type definition."""
    seen, waiting = {}, [client.nodes.objects]
    while waiting:
        node = waiting.pop()
        if node.nodeid in seen:
            continue
        seen[node.nodeid] = node_class = await node.read_node_class()
        if node_class == ua.NodeClass.Variable:
            await node.read_data_value(raise_on_bad_status=False)
            data_type = await node.read_data_type()
            await client.get_node(data_type).read_browse_name()
            await client.get_node(await node.read_type_definition()).read_browse_name()
        waiting += await node.get_children(refs=ua.ObjectIds.HierarchicalReferences)
    return seen


def names_of(plant):
    text = subprocess.run([plant.program, "names", plant.file, "--for", "opcua", "--csv"], check=True, text=True, capture_output=True)
    return [row["node"].split(";s=", 1)[1] for row in csv.DictReader(io.StringIO(text.stdout))]


async def check_nodes(plant, station):
    nodes = await browse(station.client)
    own = {node.Identifier for node, kind in nodes.items() if node.NamespaceIndex == station.namespace and kind == ua.NodeClass.Variable}
    missing = set(names_of(plant)) - own
    assert not missing, f"named, but not there: {missing}"
    path = ["3:DeviceSet", "2:chamber", "4:SignalSet", "2:Pressure", "4:AnalogSignal"]
    found = await station.client.nodes.objects.get_child(path)
    assert found.nodeid.Identifier == "gauge/chamber/pressure", found
    return {node.to_string() for node in nodes}


async def check_value(station):
    data = await station.data("gauge/chamber/pressure")
    age = datetime.datetime.now(datetime.timezone.utc) - data.SourceTimestamp.replace(tzinfo=datetime.timezone.utc)
    assert data.StatusCode.name == "Good" and 0.08 < data.Value.Value < 0.12, data
    assert data.Value.VariantType == ua.VariantType.Float, data
    assert -1 < age.total_seconds() < 60, age
    unit = await station.property("gauge/chamber/pressure", "EngineeringUnits")
    assert (unit.UnitId, unit.DisplayName.Text) == (5259596, "Pa"), unit
    for name in ("EURange", "InstrumentRange"):
        ends = await station.property("gauge/chamber/pressure", name)
        assert 0 < ends.Low < 1e-5 and ends.High > 1e4, ends
    words = await station.property("gauge/chamber/state", "EnumStrings")
    assert words[await station.value("gauge/chamber/state")].Text == "OK", words
    assert await station.property("gauge/chamber/pressure", "HighHighLimit") == 10.0
    assert (await station.value("gauge/load lock/simulated"), await station.value("gauge/chamber/simulated")) == (True, False)
    health = await station.property("gauge/chamber/device-health", "EnumStrings")
    assert health[await station.value("gauge/chamber/device-health")].Text == "NORMAL"
    limits = await station.client.nodes.server.get_child(["0:ServerCapabilities", "0:OperationLimits", "0:MaxNodesPerRead"])
    assert await limits.read_value() == 2000


async def check_subscription(plant, station):
    changes = Changes()
    subscription = await station.client.create_subscription(100, changes)
    await subscription.subscribe_data_change(station.node("gauge/chamber/pressure"))
    for pa in (0.2, 0.3, 0.4, 0.1):
        plant.tell(f"pressure {pa} Pa")

        async def arrived(pa=pa):
            return changes.values and changes.values[-1] is not None and abs(changes.values[-1] / pa - 1) < 0.05
        await until(f"{pa} Pa in the subscription", arrived)
    await subscription.delete()


async def check_lifetime(station):
    """The values of a client that disconnects without closing its session stay in memory for a bounded number of intervals."""
    wanted = ua.CreateSubscriptionParameters()
    wanted.RequestedPublishingInterval, wanted.RequestedLifetimeCount, wanted.RequestedMaxKeepAliveCount = 100, 1_000_000, 100_000
    revised = await station.client.uaclient.create_subscription(wanted, lambda *_: None)
    assert (revised.RevisedLifetimeCount, revised.RevisedMaxKeepAliveCount) == (600, 200), revised
    await station.client.uaclient.delete_subscriptions([revised.SubscriptionId])


async def check_alarm(plant, station):
    plant.tell("pressure 1 mbar")
    alarm = "alarm/Chamber high"

    async def is_active():
        return await station.value(f"{alarm}/alarm-active")
    await until("the alarm", is_active)
    words = await station.property(f"{alarm}/priority", "EnumStrings")
    assert words[await station.value(f"{alarm}/priority")].Text == "high"
    assert await station.value(f"{alarm}/occurrence") >= 1
    assert await station.value(f"{alarm}/alarm-acknowledged") is False
    plant.tell("pressure 1e-3 mbar")

    async def has_returned():
        return not await is_active()
    await until("the end of the alarm", has_returned)


CONDITION_FIELDS = ["EventId", "EventType", "SourceName", "Time", "Message", "Severity", "ConditionName", "Retain",
                    "ActiveState", "ActiveState/Id", "AckedState/Id", "ClientUserId", "SuppressedOrShelved", "OutOfServiceState/Id",
                    "ShelvingState/CurrentState/Id", "ShelvingState/UnshelveTime", "Comment"]


def condition_filter():
    """A filter as alarm viewers make it: fields of several types, ConditionId, and one field that this server has not."""
    condition = ua.NodeId(ua.ObjectIds.AlarmConditionType)
    fields = [ua.SimpleAttributeOperand(TypeDefinitionId=condition, AttributeId=ua.AttributeIds.Value,
                                        BrowsePath=[ua.QualifiedName(part) for part in name.split("/")]) for name in CONDITION_FIELDS]
    fields.append(ua.SimpleAttributeOperand(TypeDefinitionId=ua.NodeId(ua.ObjectIds.ConditionType), AttributeId=ua.AttributeIds.NodeId))
    return ua.EventFilter(SelectClauses=fields)


class Alarms:
    """A subscription of events, as dictionaries by the names of their fields."""

    def __init__(self, station):
        self.station, self.events = station, []

    async def __aenter__(self):
        self.subscription = await self.station.client.create_subscription(100, self)
        await self.subscription.subscribe_alarms_and_conditions(evfilter=condition_filter(), queuesize=1000)
        return self

    def event_notification(self, event):
        values = [field.Value for field in event.event_fields]
        self.events.append(dict(zip(CONDITION_FIELDS + ["ConditionId"], values, strict=True)))

    async def __aexit__(self, *_):
        await self.subscription.delete()

    async def refresh(self):
        kind = self.station.client.get_node(ua.ObjectIds.ConditionType)
        method = ua.NodeId(ua.ObjectIds.ConditionType_ConditionRefresh)
        await kind.call_method(method, ua.Variant(self.subscription.subscription_id, ua.VariantType.UInt32))

    async def newest(self, name, wanted):
        """The newest event of an alarm for which `wanted` is true."""
        async def found():
            events = [it for it in self.events if it["SourceName"] == name and wanted(it)]
            return events[-1] if events else None
        return await until(f"an event of {name}", found)


def acknowledge(station, event, event_id=None, by_type=True):
    """Calls Acknowledge of the condition of an event, by the method of the type or by that of the instance."""
    condition = station.client.get_node(event["ConditionId"])
    own = ua.NodeId(f"{event['ConditionId'].Identifier}/Acknowledge", station.namespace)
    method = ua.NodeId(ua.ObjectIds.AcknowledgeableConditionType_Acknowledge) if by_type else own
    comment = ua.Variant(ua.LocalizedText("seen"), ua.VariantType.LocalizedText)
    return condition.call_method(method, ua.Variant(event_id or event["EventId"], ua.VariantType.ByteString), comment)


async def refused_call(codes, call):
    try:
        await call
    except ua.UaStatusCodeError as error:
        assert error.code in codes, error
        return
    raise SystemExit("the call was done")


async def check_conditions(plant, viewer, engineer):
    """An alarm as a condition: its events, the refresh, who acknowledges, and which occurrence."""
    name = "Chamber high"
    async with Alarms(engineer) as alarms:
        plant.tell("pressure 1 mbar")
        raised = await alarms.newest(name, lambda it: it["ActiveState/Id"])
        assert raised["ActiveState"].Text == "Active" and raised["Severity"] == 800 and raised["Retain"], raised
        assert raised["EventType"] == ua.NodeId(ua.ObjectIds.AlarmConditionType), raised
        assert not raised["AckedState/Id"] and not raised["OutOfServiceState/Id"], raised
        condition = engineer.client.get_node(raised["ConditionId"])
        assert await (await condition.get_child(["0:ActiveState", "0:Id"])).read_value() is True
        assert await condition.read_type_definition() == ua.NodeId(ua.ObjectIds.AlarmConditionType)
        before = len(alarms.events)
        await alarms.refresh()
        await until("the end of the refresh", lambda: ended(alarms, before))
        again = alarms.events[before:]
        kinds = [it["EventType"].Identifier for it in again]
        begin, end = kinds.index(ua.ObjectIds.RefreshStartEventType), kinds.index(ua.ObjectIds.RefreshEndEventType)
        assert any(it["ConditionId"] == raised["ConditionId"] for it in again[begin + 1:end]), again
        denied = (ua.StatusCodes.BadUserAccessDenied,)
        await refused_call(denied, acknowledge(viewer, raised))
        other = b"\0" * 8 + raised["EventId"][8:]
        await refused_call((ua.StatusCodes.BadEventIdUnknown,), acknowledge(engineer, raised, other))
        await refused_call((ua.StatusCodes.BadEventIdUnknown,), acknowledge(engineer, raised, b"x"))
        disable = ua.NodeId(ua.ObjectIds.ConditionType_Disable)
        await refused_call(denied, condition.call_method(disable))
        await acknowledge(engineer, raised)
        seen = await alarms.newest(name, lambda it: it["AckedState/Id"] and it["ActiveState/Id"])
        assert seen["ClientUserId"] == "ada", seen
        await refused_call((ua.StatusCodes.BadConditionBranchAlreadyAcked,), acknowledge(engineer, raised, by_type=False))
        plant.tell("pressure 1e-3 mbar")
        ended_event = await alarms.newest(name, lambda it: not it["ActiveState/Id"])
        assert not ended_event["Retain"], ended_event
        plant.tell("pressure 1 mbar")
        second = await alarms.newest(name, lambda it: it["ActiveState/Id"] and it["EventId"][:8] != raised["EventId"][:8])
        await refused_call((ua.StatusCodes.BadEventIdUnknown,), acknowledge(engineer, raised))
        await acknowledge(engineer, second, by_type=False)
        plant.tell("pressure 1e-3 mbar")
        await alarms.newest(name, lambda it: not it["ActiveState/Id"] and it["EventId"][:8] == second["EventId"][:8])


async def check_shelving(plant, viewer, engineer):
    """An operator shelves an active alarm for a time and unshelves it, by the methods of the type and by those of the instance."""
    name, codes = "Chamber high", ua.StatusCodes
    condition = engineer.node("alarm/Chamber high/condition")
    shelving = await condition.get_child(["0:ShelvingState"])
    assert await shelving.read_type_definition() == ua.NodeId(ua.ObjectIds.ShelvedStateMachineType)
    limit = await (await condition.get_child(["0:MaxTimeShelved"])).read_value()
    hour = ua.Variant(3_600_000.0, ua.VariantType.Double)
    of_type = {it: ua.NodeId(getattr(ua.ObjectIds, f"AlarmConditionType_ShelvingState_{it}")) for it in ("TimedShelve", "OneShotShelve", "Unshelve")}
    async with Alarms(engineer) as alarms:
        plant.tell("pressure 1 mbar")
        raised = await alarms.newest(name, lambda it: it["ActiveState/Id"])
        assert raised["ShelvingState/CurrentState/Id"].Identifier == ua.ObjectIds.ShelvedStateMachineType_Unshelved, raised
        await refused_call((codes.BadUserAccessDenied,), viewer.client.get_node(shelving.nodeid).call_method("0:TimedShelve", hour))
        await refused_call((codes.BadConditionNotShelved,), shelving.call_method("0:Unshelve"))
        for wrong in (0.0, -1.0, float("nan"), limit + 1.0):
            time_of = ua.Variant(wrong, ua.VariantType.Double)
            await refused_call((codes.BadShelvingTimeOutOfRange,), shelving.call_method("0:TimedShelve", time_of))
        await refused_call((codes.BadNotExecutable,), shelving.call_method(of_type["OneShotShelve"]))
        await refused_call((codes.BadUserAccessDenied,), shelving.call_method("0:OneShotShelve"))
        await shelving.call_method(of_type["TimedShelve"], hour)
        shelved = await alarms.newest(name, lambda it: it["SuppressedOrShelved"])
        assert shelved["ShelvingState/CurrentState/Id"].Identifier == ua.ObjectIds.ShelvedStateMachineType_TimedShelved, shelved
        assert not shelved["ActiveState/Id"] and shelved["Retain"] and shelved["ClientUserId"] == "ada", shelved
        assert 3_000_000 < shelved["ShelvingState/UnshelveTime"] <= 3_600_000, shelved
        rest = await shelving.get_child(["0:UnshelveTime"])

        async def passes():
            return await rest.read_value() < shelved["ShelvingState/UnshelveTime"] - 1000
        await until("the time to pass", passes)
        await refused_call((codes.BadConditionAlreadyShelved,), shelving.call_method("0:TimedShelve", hour))
        await shelving.call_method("0:Unshelve")
        # The condition still holds, so the alarm is raised again.
        await alarms.newest(name, lambda it: it["ActiveState/Id"] and it["EventId"][:8] != raised["EventId"][:8])
        reason = ua.Variant(ua.LocalizedText("the lock is vented"), ua.VariantType.LocalizedText)
        await shelving.call_method("0:TimedShelve2", hour, reason)
        told = await alarms.newest(name, lambda it: it["Comment"].Text == "the lock is vented")
        assert told["SuppressedOrShelved"], told
        plant.tell("pressure 1e-3 mbar")
        await condition.call_method(of_type["Unshelve"])
        # It may be raised once more before the pressure is read.
        await alarms.newest(name, lambda it: not it["SuppressedOrShelved"] and alarms.events.index(it) > alarms.events.index(told))


async def ended(alarms, before):
    return any(it["EventType"].Identifier == ua.ObjectIds.RefreshEndEventType for it in alarms.events[before:])


async def check_types(station):
    """The types of DI and PA-DIM, by the namespaces and numbers of their specifications."""
    di = await station.client.get_namespace_index("http://opcfoundation.org/UA/DI/")
    pa_dim = await station.client.get_namespace_index("http://opcfoundation.org/UA/PADIM/")
    device_set = station.client.get_node(ua.NodeId(5001, di))
    devices = {node.nodeid for node in await device_set.get_children()}
    assert station.node("gauge/chamber").nodeid in devices, devices
    wanted = {"gauge/chamber": (1002, di), "gauge/chamber/signals": (1021, pa_dim), "gauge/chamber/signal": (1022, pa_dim),
              "gauge/chamber/pressure": (1121, pa_dim), "gauge/chamber/identification": (1005, di)}
    for name, (number, namespace) in wanted.items():
        found = await station.node(name).read_type_definition()
        assert found == ua.NodeId(number, namespace), (name, found)
    parents = []
    kind = station.client.get_node(ua.NodeId(1121, pa_dim))
    while kind.nodeid != ua.NodeId(ua.ObjectIds.AnalogUnitRangeType):
        kind = (await kind.get_referenced_nodes(ua.ObjectIds.HasSubtype, ua.BrowseDirection.Inverse))[0]
        parents.append(kind.nodeid)
    assert parents[0] == ua.NodeId(1111, pa_dim), parents
    nameplate = {}
    for node in await station.node("gauge/chamber").get_properties():
        nameplate[(await node.read_browse_name()).Name] = await node.read_value()
    assert nameplate["Manufacturer"].Text and nameplate["Model"].Text == "bcg450", nameplate
    assert (nameplate["RevisionCounter"], nameplate["SerialNumber"], len(nameplate)) == (-1, "", 8), nameplate
    health = await station.node("gauge/chamber/device-health").read_data_type()
    assert health == ua.NodeId(6244, di), health


async def check_unplugged(plant, station):
    plant.tell("power 5 off")

    async def is_lost():
        return await station.status("gauge/chamber/pressure") == "BadNoCommunication"
    await until("Bad_NoCommunication", is_lost)
    data = await station.data("gauge/chamber/pressure")
    assert data.Value.Value is None, data
    words = await station.property("gauge/chamber/state", "EnumStrings")
    state = await station.data("gauge/chamber/state")
    assert state.StatusCode.name == "Good" and words[state.Value.Value].Text in ("Stale", "Starting"), state
    assert await station.status("gauge/load lock/pressure") == "Good"
    plant.tell("power 5 on")

    async def is_back():
        return await station.status("gauge/chamber/pressure") == "Good"
    await until("the gauge to come back", is_back)


async def check_history(station):
    node = station.node("gauge/chamber/pressure")

    async def with_gap():
        now = datetime.datetime.now(datetime.timezone.utc)
        values = await node.read_raw_history(now - datetime.timedelta(hours=1), now, return_bounds=False)
        has_gap = any(not it.StatusCode.is_good() and it.Value.Value is None for it in values)
        return (now, values) if has_gap else None
    # The recorder writes a moment after the reading.
    now, values = await until("the gap in the history", with_gap)
    times = [value.SourceTimestamp for value in values]
    assert len(values) >= 5 and times == sorted(times), times
    assert any(value.StatusCode.name == "Good" and 0.35 < value.Value.Value < 0.45 for value in values), values
    newest = await node.read_raw_history(times[-1], times[0], numvalues=3, return_bounds=False)
    assert [value.SourceTimestamp for value in newest][:3] == times[::-1][:3], newest
    # OPC 10000-4, 7.9: a client that never reads to the end is not refused. OPC 10000-11, 6.5.3: bounds count as values.
    before = times[0] - datetime.timedelta(seconds=1)
    for _ in range(40):
        bounded = await node.read_raw_history(before, times[-1], numvalues=3, return_bounds=True)
        assert [value.SourceTimestamp for value in bounded] == [before, *times[:2]], bounded


async def check_points(program):
    """The points of a pump controller and of a valve are shown beside a gauge; their numbers have a history with the times of their exchanges, and a gap where the slave was lost."""
    port = free_port()
    with SlavePlant(program, f'[opcua]\nlisten = "127.0.0.1:{port}"\n') as plant:
        station = await connected(port)
        speed, state = (f"gauge/turbo/parameter/{name}/parameter-number" for name in ("speed", "state"))
        shown = []
        for octets, number, code in (("03 E8 03", 1000.0, 3.0), ("00 00 00", 0.0, 0.0)):
            plant.tell(f"input 9 1 {octets}")

            async def has_value():
                data = await station.data(speed)
                return data if data.StatusCode.name == "Good" and data.Value.Value == number else None
            shown.append((await until(f"the speed {number}", has_value)).SourceTimestamp)
            data = await station.data(state)
            assert data.Value.Value == code, data
        # The gauge and the valve of the same segment.
        plant.tell("input 12 1 28 01")

        async def is_closed():
            return await station.value("gauge/gate/parameter/limit/parameter-text") == "closed"
        await until("the limit switch of the valve", is_closed)
        assert await station.value("gauge/gate/parameter/position/parameter-number") == 40.0
        assert 0.05 < await station.value("gauge/chamber/pressure") < 0.2
        plant.tell("power 9 off")

        async def recorded(name):
            now = datetime.datetime.now(datetime.timezone.utc)
            return await station.node(name).read_raw_history(now - datetime.timedelta(hours=1), now, return_bounds=False)

        async def with_gap():
            values = await recorded(speed)
            return values if values and values[-1].StatusCode.name == "BadNoCommunication" and values[-1].Value.Value is None else None
        values = await until("the gap in the history of the speed", with_gap)
        times = [value.SourceTimestamp for value in values]
        assert times == sorted(times), times
        assert all(value.Value.VariantType == ua.VariantType.Double for value in values if value.StatusCode.is_good()), values
        numbers = [value.Value.Value for value in values if value.StatusCode.name == "Good"]
        assert [number for index, number in enumerate(numbers) if index == 0 or number != numbers[index - 1]][-2:] == [1000.0, 0.0], numbers
        # The client has read the first value at its time, or at that of a later exchange with the same value.
        first = next(value.SourceTimestamp for value in values if value.Value.Value == 1000.0)
        assert first <= shown[0], (first, shown)
        assert {value.Value.Value for value in await recorded(state)} >= {0.0, 3.0}
        unit = await station.property(speed, "EngineeringUnits")
        assert unit.DisplayName.Text == "Hz", unit
        try:
            await recorded("gauge/turbo/parameter/speed/parameter-text")
            raise AssertionError("a text has a history")
        except ua.UaStatusCodeError as error:
            assert error.code in (ua.StatusCodes.BadHistoryOperationUnsupported, ua.StatusCodes.BadUserAccessDenied), error
        await station.client.disconnect()


async def check_read_only(plant, station):
    before = plant.status("opcua")["refused"]
    for name in ("gauge/chamber/pressure", "station/version"):
        try:
            await station.node(name).write_value(ua.Variant(1.0, ua.VariantType.Float))
            raise SystemExit(f"{name} was written")
        except ua.UaStatusCodeError as error:
            assert error.code in (ua.StatusCodes.BadNotWritable, ua.StatusCodes.BadUserAccessDenied), error
    assert plant.status("opcua")["refused"] > before


async def secure(port, folder, user=None, password=None):
    """A connection with Basic256Sha256, signed and encrypted."""
    client = Client(f"opc.tcp://127.0.0.1:{port}/", timeout=HANG_S, watchdog_intervall=HANG_S)
    client.application_uri = "urn:test:client"
    certificate, key = os.path.join(folder, "client.der"), os.path.join(folder, "client.pem")
    if not os.path.exists(certificate):
        await setup_self_signed_certificate(
            __import__("pathlib").Path(key), __import__("pathlib").Path(certificate), client.application_uri, "localhost",
            [ExtendedKeyUsageOID.CLIENT_AUTH], {"commonName": "test client", "organizationName": "test"})
    if user:
        client.set_user(user)
        client.set_password(password)
    await client.set_security(SecurityPolicyBasic256Sha256, certificate, key, mode=ua.MessageSecurityMode.SignAndEncrypt)
    return Station(port, client)


async def is_refused(port, folder, user, password):
    try:
        async with await secure(port, folder, user, password):
            return False
    except (ua.UaError, OSError, asyncio.TimeoutError):
        return True


async def check_security(plant, port):
    certificates = os.path.join(plant.folder, "plant.opcua")
    rejected, trusted = os.path.join(certificates, "rejected"), os.path.join(certificates, "trusted")
    assert os.stat(os.path.join(certificates, "private/private.pem")).st_mode & 0o077 == 0
    subprocess.run([plant.program, "user", "add", "scada", "--role", "viewer", plant.file, "--password-stdin"],
                   input=PASSWORD + "\n", text=True, check=True, capture_output=True)
    assert await is_refused(port, plant.folder, "scada", PASSWORD), "an unknown certificate was accepted"
    unknown = os.listdir(rejected)
    assert len(unknown) == 1, unknown
    shutil.move(os.path.join(rejected, unknown[0]), trusted)
    async with await secure(port, plant.folder, "scada", PASSWORD) as station:
        assert await station.status("gauge/chamber/pressure") == "Good"
    assert await is_refused(port, plant.folder, "scada", "wrong"), "a wrong password was accepted"
    assert await is_refused(port, plant.folder, "nobody", PASSWORD), "an unknown user was accepted"
    assert await is_refused(port, plant.folder, None, None), "a client without a user was accepted"


async def check_node_opcua(plant, port):
    """A second client, which shares no code with asyncua and with the server."""
    client = os.path.join(os.path.dirname(os.path.abspath(__file__)), "node-opcua", "client.js")
    arguments = ["node", client, f"opc.tcp://127.0.0.1:{port}/", "scada", PASSWORD, plant.folder]
    done = await asyncio.to_thread(subprocess.run, arguments, text=True, capture_output=True, timeout=HANG_S)
    assert done.returncode == 0, done.stdout + done.stderr
    print("\n".join(line for line in done.stdout.splitlines() if line.startswith("node-opcua:")), flush=True)


async def refused_with(codes, node, value):
    try:
        await node.write_value(ua.Variant(value, ua.VariantType.Float))
    except ua.UaStatusCodeError as error:
        assert error.code in codes, error
        return
    raise SystemExit(f"{node} took {value}")


async def check_writing(plant, port):
    """With write = true a user who logs in writes a parameter, as far as the role allows, and the audit trail has it."""
    subprocess.run([plant.program, "user", "add", "ada", "--role", "engineer", plant.file, "--password-stdin"],
                   input=PASSWORD + "\n", text=True, check=True, capture_output=True)
    plant.stop()
    with open(plant.file) as file:
        text = file.read()
    plant.write("plant.toml", text.replace("[opcua]\n", "[opcua]\nwrite = true\n"))
    plant.station = subprocess.Popen([plant.program, "run", plant.file, "--listen", "127.0.0.1:0"], stdout=subprocess.PIPE, text=True)
    plant.url = plant.station.stdout.readline().split()[1]
    name = "gauge/load lock/parameter/trip-point.1/high-trip-point/parameter-pressure"
    station = await connected(port)

    async def is_read():
        return await station.status(name) == "Good"
    await until("the trip point", is_read)
    denied = (ua.StatusCodes.BadUserAccessDenied,)
    await refused_with(denied, station.node(name), 0.5)
    await station.client.disconnect()
    async with await secure(port, plant.folder, "scada", PASSWORD) as viewer:
        await refused_with(denied, viewer.node(name), 0.5)
    async with await secure(port, plant.folder, "ada", PASSWORD) as engineer:
        level = await engineer.node(name).get_access_level()
        assert ua.AccessLevel.CurrentWrite in level, level
        await engineer.node(name).write_value(ua.Variant(0.5, ua.VariantType.Float))

        async def arrived():
            # Until the gauge is read again, what it had before the write is no value.
            value = await engineer.value(name)
            return value is not None and abs(value / 0.5 - 1) < 1e-3
        await until("the value that was written", arrived)
        await refused_with((ua.StatusCodes.BadOutOfRange,), engineer.node(name), 1e30)
        await refused_with((ua.StatusCodes.BadNotWritable,), engineer.node("gauge/chamber/pressure"), 1.0)
        async with await secure(port, plant.folder, "scada", PASSWORD) as viewer:
            await check_conditions(plant, viewer, engineer)
            await check_shelving(plant, viewer, engineer)
    opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
    body = json.dumps({"name": "ada", "password": PASSWORD}).encode()
    opener.open(urllib.request.Request(plant.url + "/api/login", body, {"Content-Type": "application/json"}), timeout=HANG_S).close()
    with opener.open(plant.url + "/api/audit", timeout=HANG_S) as answer:
        rows = json.load(answer)
    assert any(row["action"] == "outcome" and row["user"] == "ada" and row["outcome"] == "done" for row in rows), rows
    refused = {row["user"] for row in rows if row["action"] == "refused"}
    assert refused == {"ada", "scada"}, rows


async def check_hostile(plant, port):
    async with Station(port) as station:
        with Line(plant.url), Hostile(port, HOSTILE) as hostile:
            end = time.monotonic() + 5
            times = set()
            while time.monotonic() < end or len(times) < 3:
                data = await station.data("gauge/chamber/pressure")
                assert data.StatusCode.name == "Good", data
                times.add(data.SourceTimestamp)
                await asyncio.sleep(POLL_S)
        print(f"{hostile.made / hostile.seconds:.0f} hostile connections a second; another client got {len(times)} readings", flush=True)
    (await connected(port)).client  # a new client is served afterwards
    assert plant.station.poll() is None, "the station ended"


def costly_filter(elements):
    """A filter whose elements refer to the next one twice: the paths between them double with each element."""
    both = lambda index: [ua.ElementOperand(Index=index + 1), ua.ElementOperand(Index=index + 1)]
    found = [ua.ContentFilterElement(FilterOperator=ua.FilterOperator.And, FilterOperands=both(index)) for index in range(elements)]
    one = ua.LiteralOperand(Value=ua.Variant(1))
    found.append(ua.ContentFilterElement(FilterOperator=ua.FilterOperator.Equals, FilterOperands=[one, one]))
    costly = condition_filter()
    costly.WhereClause = ua.ContentFilter(Elements=found)
    return costly


async def check_filters(port):
    """A filter with few paths is accepted; one with 2^40 is refused, and the other clients go on."""
    async with Station(port) as hostile, Station(port) as station:
        subscription = await hostile.client.create_subscription(100, Changes())
        await subscription.subscribe_alarms_and_conditions(evfilter=costly_filter(3))
        try:
            await subscription.subscribe_alarms_and_conditions(evfilter=costly_filter(40))
        except (ua.UaError, ConnectionError, asyncio.CancelledError) as error:
            print(f"a costly filter is refused: {error!r}", flush=True)
        else:
            raise AssertionError("a filter with 2^40 paths is accepted")
        assert (await station.data("gauge/chamber/pressure")).StatusCode.name == "Good"


def item_of(station, name, **parameters):
    node = station.node(name).nodeid
    return ua.MonitoredItemCreateRequest(
        ItemToMonitor=ua.ReadValueId(node, ua.AttributeIds.Value), MonitoringMode=ua.MonitoringMode.Reporting,
        RequestedParameters=ua.MonitoringParameters(**parameters))


async def make_items(station, subscription, items):
    wanted = ua.CreateMonitoredItemsParameters(subscription, ua.TimestampsToReturn.Both, items)
    return await station.client.uaclient.create_monitored_items(wanted)


async def leave_behind(port):
    """A session with four subscriptions of 2,000 values that is closed without them. They would live for 600 hours."""
    wanted = ua.CreateSubscriptionParameters(RequestedPublishingInterval=3_600_000)
    async with Station(port) as station:
        items = [item_of(station, "gauge/chamber/simulated")] * 1000
        for _ in range(4):
            made = await station.client.uaclient.create_subscription(wanted, lambda *_: None)
            for _ in range(2):
                results = await make_items(station, made.SubscriptionId, items)
                assert all(it.StatusCode.is_good() for it in results), results[0]
        await station.client.uaclient.close_session(False)


def restarts(plant):
    return "starts again" in (plant.status("opcua")["last_error"] or "")


async def check_abandoned(plant, port):
    """Clients leave as many subscriptions behind as they may, and more: the server starts again and frees them."""
    async with Station(port) as other:
        for _ in range(24):
            await leave_behind(port)
        assert await other.status("gauge/chamber/pressure") == "Good"
        assert not restarts(plant), plant.status("opcua")

        async def is_new():
            if not restarts(plant):
                await leave_behind(port)
            return restarts(plant)
        await until("a new server", is_new)
        try:
            await other.status("gauge/chamber/pressure")
        except (OSError, ua.UaError, asyncio.TimeoutError, asyncio.CancelledError):
            pass
        else:
            raise AssertionError("a session of the server before lives on")
    station = await connected(port)

    async def is_good():
        return await station.status("gauge/chamber/pressure") == "Good"
    await until("a reading of the new server", is_good)
    await station.client.disconnect()


async def check_items(plant, port):
    """Items that would take memory for ever are refused, and what a client deletes leaves little."""
    async with Station(port) as station:
        subscription = await station.client.create_subscription(1000, Changes())
        refused = [
            item_of(station, "gauge/chamber/" + "x" * 900),
            item_of(station, "gauge/chamber/pressure", Filter=condition_filter()),
        ]
        results = await make_items(station, subscription.subscription_id, refused)
        assert [it.StatusCode.name for it in results] == ["BadNodeIdUnknown", "BadFilterNotAllowed"], results
        missing = item_of(station, "x")
        missing.ItemToMonitor.NodeId = ua.NodeId("x", 0)
        results = await make_items(station, subscription.subscription_id, [missing])
        assert [it.StatusCode.name for it in results] == ["BadNodeIdUnknown"], results
        await subscription.delete()
        # A trend display opens and closes a page a thousand times.
        page = [item_of(station, "gauge/chamber/pressure")] * 100
        parameters = ua.CreateSubscriptionParameters(RequestedPublishingInterval=100)
        for _ in range(1000):
            made = await station.client.uaclient.create_subscription(parameters, lambda *_: None)
            await make_items(station, made.SubscriptionId, page)
            await station.client.uaclient.delete_subscriptions([made.SubscriptionId])
        assert not restarts(plant), plant.status("opcua")


async def check_long_filter(port):
    """A filter with thousands of fields is refused, also when an item is changed."""
    async with Station(port) as station:
        subscription = await station.client.create_subscription(1000, Changes())
        item = await subscription.subscribe_alarms_and_conditions(evfilter=condition_filter())
        long = condition_filter()
        long.SelectClauses = long.SelectClauses * 200
        change = ua.MonitoredItemModifyRequest(item, ua.MonitoringParameters(Filter=long, QueueSize=10))
        wanted = ua.ModifyMonitoredItemsParameters(
            SubscriptionId=subscription.subscription_id, TimestampsToReturn=ua.TimestampsToReturn.Both, ItemsToModify=[change])
        try:
            await station.client.uaclient.modify_monitored_items(wanted)
        except (ua.UaError, ConnectionError, asyncio.CancelledError, asyncio.TimeoutError) as error:
            print(f"a long filter is refused: {error!r}", flush=True)
        else:
            raise AssertionError("a filter with thousands of fields is accepted")


async def check_chunks(port):
    """A client that begins a chunk of 4 GiB is disconnected."""
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    writer.write(b"HELF" + (2**32 - 1).to_bytes(4, "little"))
    assert await asyncio.wait_for(reader.read(), HANG_S) == b""
    writer.close()


async def main(program):
    port = free_port()
    with Plant(program, f'[opcua]\nlisten = "127.0.0.1:{port}"\n') as plant:
        station = await connected(port)

        async def has_reading():
            return await station.status("gauge/chamber/pressure") == "Good"
        await until("a reading", has_reading)
        steps = [
            ("values", lambda: check_value(station)),
            ("types", lambda: check_types(station)),
            ("subscription", lambda: check_subscription(plant, station)),
            ("lifetime of subscriptions", lambda: check_lifetime(station)),
            ("alarm", lambda: check_alarm(plant, station)),
            ("unplugged gauge", lambda: check_unplugged(plant, station)),
            ("history", lambda: check_history(station)),
            ("read-only", lambda: check_read_only(plant, station)),
        ]
        before = await check_nodes(plant, station)
        for name, step in steps:
            began = time.monotonic()
            await step()
            print(f"{name}: {time.monotonic() - began:.1f} s", flush=True)
        await station.client.disconnect()
        plant.restart()
        station = await connected(port)
        await until("a reading", has_reading)
        after = await check_nodes(plant, station)
        assert before == after, before ^ after
        await station.client.disconnect()
        print("restart", flush=True)
        await check_filters(port)
        await check_chunks(port)
        print("filters", flush=True)
        await check_long_filter(port)
        await check_items(plant, port)
        await check_abandoned(plant, port)
        print("subscriptions left behind", flush=True)
        await check_hostile(plant, port)
        await check_security(plant, port)
        print("security", flush=True)
        await check_node_opcua(plant, port)
        await check_writing(plant, port)
        print("writing", flush=True)
    await check_points(program)
    print("points of a slave", flush=True)


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1]))
