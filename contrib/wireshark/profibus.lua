-- PROFIBUS DP for Wireshark: FDL telegrams, the services of DP-V0, the PDUs of DP-V1, diagnosis.
--
-- A packet is one telegram, from start to end delimiter, as `profivac sniff --out` and `profivac decode --out` write it with
-- link type 147 (USER0). See README.md beside this file.

local proto = Proto("profibus", "PROFIBUS DP")

-- Names ------------------------------------------------------------------------------------------------------------------

local START = { [0x10] = "SD1", [0x68] = "SD2", [0xA2] = "SD3", [0xDC] = "SD4 (token)", [0xE5] = "SC" }

local FUNCTION = {
    [0x03] = "SDA low", [0x04] = "SDN low", [0x05] = "SDA high", [0x06] = "SDN high", [0x09] = "FDL_Status",
    [0x0C] = "SRD low", [0x0D] = "SRD high", [0x0E] = "Ident", [0x0F] = "LSAP_Status",
}

local STATUS = {
    [0x00] = "OK", [0x01] = "UE", [0x02] = "RR", [0x03] = "RS", [0x08] = "DL", [0x09] = "NR", [0x0A] = "DH",
    [0x0C] = "RDL", [0x0D] = "RDH",
}

local STATION = {
    [0] = "passive", [1] = "active, not ready", [2] = "active, ready", [3] = "active, in the ring",
}

local SERVICE = {
    [49] = "MS2 Initiate", [50] = "MS1 Alarm", [51] = "MS1", [53] = "Set_Ext_Prm", [55] = "Set_Slave_Add",
    [56] = "RD_Inp", [57] = "RD_Outp", [58] = "Global_Control", [59] = "Get_Cfg", [60] = "Slave_Diag",
    [61] = "Set_Prm", [62] = "Chk_Cfg",
}

local PDU = {
    [0x48] = "Idle", [0x51] = "Data_Transport", [0x56] = "RM", [0x57] = "Initiate", [0x58] = "Abort",
    [0x5C] = "Alarm_Ack", [0x5E] = "Read", [0x5F] = "Write",
}

local ERROR_DECODE = { [128] = "DP-V1", [254] = "FMS", [255] = "HART" }

local ERROR_CODE = {
    [0xA0] = "read error", [0xA1] = "write error", [0xA2] = "module failure", [0xA8] = "version conflict",
    [0xA9] = "feature not supported", [0xB0] = "invalid index", [0xB1] = "write length error", [0xB2] = "invalid slot",
    [0xB3] = "type conflict", [0xB4] = "invalid area", [0xB5] = "state conflict", [0xB6] = "access denied",
    [0xB7] = "invalid range", [0xB8] = "invalid parameter", [0xB9] = "invalid type", [0xC0] = "read constraint conflict",
    [0xC1] = "write constraint conflict", [0xC2] = "resource busy", [0xC3] = "resource unavailable",
}

local ABORT = {
    [0x01] = "UE", [0x02] = "RR", [0x03] = "RS", [0x09] = "NR", [0x0A] = "DH", [0x0B] = "LR", [0x0C] = "RDL",
    [0x0D] = "RDH", [0x0E] = "DS", [0x0F] = "NA", [0x11] = "ABT_SE", [0x12] = "ABT_FE", [0x13] = "ABT_TO",
    [0x14] = "ABT_RE", [0x15] = "ABT_IV", [0x16] = "ABT_STO", [0x17] = "ABT_IA", [0x18] = "ABT_OC", [0x1F] = "ABT_RES",
}

local ALARM = {
    [1] = "diagnostic alarm", [2] = "process alarm", [3] = "pull alarm", [4] = "plug alarm", [5] = "status alarm",
    [6] = "update alarm", [0x81] = "status message", [0x82] = "module status", [0x83] = "DXB link status",
    [0x9E] = "PrmCmdAck", [0x9F] = "Red_State",
}

local SPECIFIER = { [0] = "no further information", [1] = "appears", [2] = "disappears", [3] = "disappears, others remain" }

local MODULE_STATUS = { [0] = "valid", [1] = "invalid data", [2] = "wrong module", [3] = "no module" }

local CHANNEL_ERROR = {
    [1] = "short circuit", [2] = "undervoltage", [3] = "overvoltage", [4] = "overload", [5] = "overtemperature",
    [6] = "line break", [7] = "upper limit exceeded", [8] = "lower limit exceeded", [9] = "error",
}
for error = 0, 31 do
    CHANNEL_ERROR[error] = CHANNEL_ERROR[error] or error < 16 and "reserved" or "manufacturer specific"
end

-- Fields -----------------------------------------------------------------------------------------------------------------

local f = proto.fields
local NONE, DEC, HEX = base.NONE, base.DEC, base.HEX

local function field(name, make, title, ...)
    f[name] = make("profibus." .. name, title, ...)
end

field("sd", ProtoField.uint8, "Start delimiter", HEX, START)
field("le", ProtoField.uint8, "Length (LE)", DEC)
field("ler", ProtoField.uint8, "Length repeated (LEr)", DEC)
field("da", ProtoField.uint8, "Destination address", DEC, nil, 0x7F)
field("sa", ProtoField.uint8, "Source address", DEC, nil, 0x7F)
field("dae", ProtoField.bool, "Destination access point follows", 8, nil, 0x80)
field("sae", ProtoField.bool, "Source access point follows", 8, nil, 0x80)
field("fc", ProtoField.uint8, "Frame control", HEX)
field("request", ProtoField.bool, "Request", 8, nil, 0x40)
field("fcb", ProtoField.uint8, "Frame count bit", DEC, nil, 0x20)
field("fcv", ProtoField.uint8, "Frame count bit valid", DEC, nil, 0x10)
field("function", ProtoField.uint8, "Function", HEX, FUNCTION, 0x0F)
field("station", ProtoField.uint8, "Station type", DEC, STATION, 0x30)
field("status", ProtoField.uint8, "Status", HEX, STATUS, 0x0F)
field("dsap", ProtoField.uint8, "Destination access point", DEC)
field("ssap", ProtoField.uint8, "Source access point", DEC)
field("service", ProtoField.string, "Service")
field("data", ProtoField.bytes, "Data unit", base.SPACE)
field("fcs", ProtoField.uint8, "Check octet (FCS)", HEX)
field("ed", ProtoField.uint8, "End delimiter", HEX)

local function bit(name, title, width, mask)
    field(name, ProtoField.bool, title, width, nil, mask)
end

field("diag.status", ProtoField.uint24, "Station status", HEX)
bit("diag.station_non_existent", "Station_Non_Existent", 24, 0x010000)
bit("diag.station_not_ready", "Station_Not_Ready", 24, 0x020000)
bit("diag.cfg_fault", "Cfg_Fault", 24, 0x040000)
bit("diag.ext_diag", "Ext_Diag", 24, 0x080000)
bit("diag.not_supported", "Not_Supported", 24, 0x100000)
bit("diag.invalid_slave_response", "Invalid_Slave_Response", 24, 0x200000)
bit("diag.prm_fault", "Prm_Fault", 24, 0x400000)
bit("diag.master_lock", "Master_Lock", 24, 0x800000)
bit("diag.prm_req", "Prm_Req", 24, 0x000100)
bit("diag.stat_diag", "Stat_Diag", 24, 0x000200)
bit("diag.wd_on", "WD_On", 24, 0x000800)
bit("diag.freeze_mode", "Freeze_Mode", 24, 0x001000)
bit("diag.sync_mode", "Sync_Mode", 24, 0x002000)
bit("diag.deactivated", "Deactivated", 24, 0x008000)
bit("diag.ext_diag_overflow", "Ext_Diag_Overflow", 24, 0x000080)
field("diag.master", ProtoField.uint8, "Master address", DEC)
field("ident", ProtoField.uint16, "Ident number", HEX)
field("diag.device", ProtoField.bytes, "Device-related diagnosis", base.SPACE)
field("diag.as_dpv1", ProtoField.bytes, "As DP-V1", base.SPACE)
field("diag.alarm", ProtoField.uint8, "Alarm or status type", HEX, ALARM)
field("diag.slot", ProtoField.uint8, "Slot", DEC)
field("diag.specifier", ProtoField.uint8, "Specifier", DEC, SPECIFIER, 0x03)
field("diag.sequence", ProtoField.uint8, "Sequence number", DEC, nil, 0xF8)
field("diag.module_status", ProtoField.string, "Module status")
field("diag.identifier", ProtoField.bytes, "Identifier-related diagnosis", base.SPACE)
field("diag.channel", ProtoField.uint8, "Channel", DEC, nil, 0x3F)
field("diag.channel_module", ProtoField.uint8, "Module of the channel", DEC, nil, 0x3F)
field("diag.channel_error", ProtoField.uint8, "Error of the channel", DEC, CHANNEL_ERROR, 0x1F)
field("diag.revision", ProtoField.uint8, "Revision", DEC, nil, 0x3F)

field("prm.status", ProtoField.uint8, "Station status", HEX)
bit("prm.wd_on", "WD_On", 8, 0x08)
bit("prm.freeze", "Freeze_Req", 8, 0x10)
bit("prm.sync", "Sync_Req", 8, 0x20)
bit("prm.unlock", "Unlock_Req", 8, 0x40)
bit("prm.lock", "Lock_Req", 8, 0x80)
field("prm.wd_fact_1", ProtoField.uint8, "WD_Fact_1", DEC)
field("prm.wd_fact_2", ProtoField.uint8, "WD_Fact_2", DEC)
field("prm.min_tsdr", ProtoField.uint8, "min T_SDR", DEC)
field("prm.group", ProtoField.uint8, "Group_Ident", HEX)
field("prm.user", ProtoField.bytes, "User parameters", base.SPACE)

field("cfg", ProtoField.bytes, "Configuration", base.SPACE)
field("cfg.outputs", ProtoField.uint16, "Octets to the slave", DEC)
field("cfg.inputs", ProtoField.uint16, "Octets from the slave", DEC)

field("gc.command", ProtoField.uint8, "Command", HEX)
bit("gc.clear", "Clear_Data", 8, 0x02)
bit("gc.unfreeze", "Unfreeze", 8, 0x04)
bit("gc.freeze", "Freeze", 8, 0x08)
bit("gc.unsync", "Unsync", 8, 0x10)
bit("gc.sync", "Sync", 8, 0x20)
field("gc.group", ProtoField.uint8, "Groups", HEX)

field("ssa.address", ProtoField.uint8, "New address", DEC)
field("ssa.locked", ProtoField.uint8, "No further change", DEC)

field("pdu", ProtoField.uint8, "Function number", HEX, PDU, 0x7F)
field("pdu.negative", ProtoField.bool, "Negative response", 8, nil, 0x80)
field("pdu.slot", ProtoField.uint8, "Slot", DEC)
field("pdu.index", ProtoField.uint8, "Index", DEC)
field("pdu.length", ProtoField.uint8, "Length", DEC)
field("pdu.data", ProtoField.bytes, "Record", base.SPACE)
field("pdu.error_decode", ProtoField.uint8, "Error_Decode", DEC, ERROR_DECODE)
field("pdu.error_code_1", ProtoField.uint8, "Error_Code_1", HEX, ERROR_CODE)
field("pdu.error_code_2", ProtoField.uint8, "Error_Code_2", DEC)
field("pdu.server_sap", ProtoField.uint8, "Access point of the connection", DEC)
field("pdu.send_timeout", ProtoField.uint16, "Send_Timeout in 10 ms", DEC)
field("pdu.features", ProtoField.bytes, "Features and profile", base.SPACE)
field("pdu.max_len", ProtoField.uint8, "Longest record", DEC)
field("pdu.subnet", ProtoField.uint8, "Subnet", DEC)
field("pdu.reason", ProtoField.uint8, "Reason", HEX, ABORT)
field("pdu.alarm_type", ProtoField.uint8, "Alarm type", DEC, ALARM)
field("pdu.specifier", ProtoField.uint8, "Specifier", HEX)

field("response_in", ProtoField.framenum, "Answer in", NONE, frametype.RESPONSE)
field("request_in", ProtoField.framenum, "Request in", NONE, frametype.REQUEST)
field("repeats", ProtoField.framenum, "Repetition of", NONE, frametype.RETRANS_PREV)
field("refused_service", ProtoField.string, "Refused service")
field("invented_time", ProtoField.bool, "Invented time")

local damaged = ProtoExpert.new("profibus.damaged", "Damaged telegram", expert.group.MALFORMED, expert.severity.ERROR)
local refused = ProtoExpert.new("profibus.refused", "Refused", expert.group.RESPONSE_CODE, expert.severity.WARN)
local repetition =
    ProtoExpert.new("profibus.repetition", "Repetition", expert.group.SEQUENCE, expert.severity.WARN)
local unanswered =
    ProtoExpert.new("profibus.unanswered", "No answer", expert.group.SEQUENCE, expert.severity.WARN)
local invented =
    ProtoExpert.new("profibus.invented", "Invented time", expert.group.ASSUMPTION, expert.severity.CHAT)
proto.experts = { damaged, refused, repetition, unanswered, invented }

-- The description of the interface says whether its times are invented.
local interface = Field.new("frame.interface_description")

-- DP-V0 ------------------------------------------------------------------------------------------------------------------

-- The names of the set bits.
local function set_bits(value, names)
    local words = {}
    for _, name in ipairs(names) do
        if math.floor(value / name[1]) % 2 == 1 then
            words[#words + 1] = name[2]
        end
    end
    return table.concat(words, ", ")
end

local DIAG_BITS = {
    { 0x010000, "Station_Non_Existent" }, { 0x020000, "Station_Not_Ready" }, { 0x040000, "Cfg_Fault" },
    { 0x080000, "Ext_Diag" }, { 0x100000, "Not_Supported" }, { 0x200000, "Invalid_Slave_Response" },
    { 0x400000, "Prm_Fault" }, { 0x800000, "Master_Lock" }, { 0x000100, "Prm_Req" }, { 0x000200, "Stat_Diag" },
    { 0x000800, "WD_On" }, { 0x001000, "Freeze_Mode" }, { 0x002000, "Sync_Mode" }, { 0x008000, "Deactivated" },
    { 0x000080, "Ext_Diag_Overflow" },
}

local DIAG_FIELDS = {
    "station_non_existent", "station_not_ready", "cfg_fault", "ext_diag", "not_supported", "invalid_slave_response",
    "prm_fault", "master_lock", "prm_req", "stat_diag", "wd_on", "freeze_mode", "sync_mode", "deactivated",
    "ext_diag_overflow",
}

-- A device-related block: type, slot, specifier, data. Module status has two bits for each module.
local function device_block(block, tree)
    tree:add(f["diag.alarm"], block(1, 1))
    tree:add(f["diag.slot"], block(2, 1))
    tree:add(f["diag.specifier"], block(3, 1))
    local kind = block(1, 1):uint()
    if kind < 0x80 then tree:add(f["diag.sequence"], block(3, 1)) end
    if kind ~= 0x82 then return end
    for at = 4, block:len() - 1 do
        local octet = block(at, 1):uint()
        for number = 0, 3 do
            local status = math.floor(octet / 4 ^ number) % 4
            if status ~= 0 then
                local words = string.format("module %d: %s", (at - 4) * 4 + number, MODULE_STATUS[status])
                tree:add(f["diag.module_status"], block(at, 1), words)
            end
        end
    end
end

-- The tree for the DP-V1 fields of a device-related block; nil if its format is the vendor's, or its type has no meaning. The fields have a tree
-- of their own if the traffic does not decide.
local function as_dpv1(block, tree, format)
    if block:len() < 4 then return nil end
    local kind = block(1, 1):uint()
    local is_manufacturer = kind % 128 >= 32 and kind % 128 < 127
    if not (ALARM[kind] or is_manufacturer) then return nil end
    if format == "messages" then return tree end
    if format == "vendor or module status" and kind ~= 0x82 then return nil end
    return tree:add(f["diag.as_dpv1"], block):set_generated()
end

-- The blocks of an extended diagnosis: device, identifier, channel, revision. `format` is the format of the device-related ones.
local function ext_diag(du, tree, format)
    local at = 6
    while at < du:len() do
        local header = du(at, 1):uint()
        local kind, low = math.floor(header / 64), header % 64
        local length = kind == 2 and 3 or kind == 3 and 1 or low
        if length == 0 or at + length > du:len() then
            tree:add_proto_expert_info(damaged, "A diagnosis block is longer than the telegram")
            return
        end
        if kind == 0 then
            local block = tree:add(f["diag.device"], du(at, length))
            local messages = as_dpv1(du(at, length), block, format)
            if messages then device_block(du(at, length), messages) end
        elseif kind == 1 then
            tree:add(f["diag.identifier"], du(at, length))
        elseif kind == 2 then
            tree:add(f["diag.channel_module"], du(at, 1))
            tree:add(f["diag.channel"], du(at + 1, 1))
            tree:add(f["diag.channel_error"], du(at + 2, 1))
        else
            tree:add(f["diag.revision"], du(at, 1))
        end
        at = at + length
    end
end

local function slave_diag(du, tree, format)
    if du:len() < 6 then return nil end
    local status = tree:add(f["diag.status"], du(0, 3))
    for _, name in ipairs(DIAG_FIELDS) do status:add(f["diag." .. name], du(0, 3)) end
    tree:add(f["diag.master"], du(3, 1))
    tree:add(f["ident"], du(4, 2))
    ext_diag(du, tree, format)
    local master = du(3, 1):uint()
    local owner = master == 255 and "no master" or "master " .. master
    local words = set_bits(du(0, 3):uint(), DIAG_BITS)
    return string.format("%s, ident %04X%s", owner, du(4, 2):uint(), words == "" and "" or ", " .. words)
end

local PRM_BITS = { { 0x80, "lock" }, { 0x40, "unlock" }, { 0x20, "sync" }, { 0x10, "freeze" }, { 0x08, "watchdog" } }

local function set_prm(du, tree)
    if du:len() < 7 then return nil end
    local status = tree:add(f["prm.status"], du(0, 1))
    for _, name in ipairs({ "wd_on", "freeze", "sync", "unlock", "lock" }) do status:add(f["prm." .. name], du(0, 1)) end
    tree:add(f["prm.wd_fact_1"], du(1, 1))
    tree:add(f["prm.wd_fact_2"], du(2, 1))
    tree:add(f["prm.min_tsdr"], du(3, 1))
    tree:add(f["ident"], du(4, 2))
    tree:add(f["prm.group"], du(6, 1))
    if du:len() > 7 then tree:add(f["prm.user"], du(7)) end
    return string.format("%s, ident %04X", set_bits(du(0, 1):uint(), PRM_BITS), du(4, 2):uint())
end

-- The number of octets of a length octet; bit 6 selects words.
local function area(octet)
    local units = octet % 64 + 1
    return math.floor(octet / 64) % 2 == 1 and 2 * units or units
end

-- The octets in each direction; nil if the last identifier is truncated.
local function lengths(du)
    local at, outputs, inputs = 0, 0, 0
    while at < du:len() do
        local octet = du(at, 1):uint()
        at = at + 1
        if math.floor(octet / 16) % 4 ~= 0 then
            local octets = octet % 16 + 1
            if math.floor(octet / 64) % 2 == 1 then octets = 2 * octets end
            if math.floor(octet / 32) % 2 == 1 then outputs = outputs + octets end
            if math.floor(octet / 16) % 2 == 1 then inputs = inputs + octets end
        else
            local follow = octet % 16 == 15 and 0 or octet % 16
            local both = math.floor(octet / 128) + math.floor(octet / 64) % 2
            if at + both + follow > du:len() then return nil end
            if octet >= 128 then
                outputs = outputs + area(du(at, 1):uint())
                at = at + 1
            end
            if math.floor(octet / 64) % 2 == 1 then
                inputs = inputs + area(du(at, 1):uint())
                at = at + 1
            end
            at = at + follow
        end
    end
    return outputs, inputs
end

local function configuration(du, tree)
    if du:len() == 0 then return nil end
    tree:add(f["cfg"], du)
    local outputs, inputs = lengths(du)
    if not outputs then
        tree:add_proto_expert_info(damaged, "The last configuration identifier announces more octets than follow")
        return "damaged configuration"
    end
    tree:add(f["cfg.outputs"], du, outputs):set_generated()
    tree:add(f["cfg.inputs"], du, inputs):set_generated()
    return string.format("%d out, %d in: %s", outputs, inputs, tostring(du:bytes():tohex(false, " ")))
end

local GC_BITS = { { 0x02, "Clear_Data" }, { 0x04, "Unfreeze" }, { 0x08, "Freeze" }, { 0x10, "Unsync" }, { 0x20, "Sync" } }

local function global_control(du, tree)
    if du:len() < 2 then return nil end
    local command = tree:add(f["gc.command"], du(0, 1))
    for _, name in ipairs({ "clear", "unfreeze", "freeze", "unsync", "sync" }) do
        command:add(f["gc." .. name], du(0, 1))
    end
    tree:add(f["gc.group"], du(1, 1))
    local words = set_bits(du(0, 1):uint(), GC_BITS)
    local group = du(1, 1):uint()
    return (words == "" and "Operate" or words) .. (group == 0 and "" or string.format(", groups %02X", group))
end

local function set_slave_add(du, tree)
    if du:len() < 4 then return nil end
    tree:add(f["ssa.address"], du(0, 1))
    tree:add(f["ident"], du(1, 2))
    tree:add(f["ssa.locked"], du(3, 1))
    return string.format("address %d, ident %04X", du(0, 1):uint(), du(1, 2):uint())
end

-- DP-V1 ------------------------------------------------------------------------------------------------------------------

local function record(du, tree, with_data)
    if du:len() < 4 then return nil end
    tree:add(f["pdu.slot"], du(1, 1))
    tree:add(f["pdu.index"], du(2, 1))
    tree:add(f["pdu.length"], du(3, 1))
    local words = string.format("slot %d index %d", du(1, 1):uint(), du(2, 1):uint())
    if not with_data or du:len() == 4 then return string.format("%s, %d octets", words, du(3, 1):uint()) end
    tree:add(f["pdu.data"], du(4))
    if du:len() - 4 ~= du(3, 1):uint() then
        tree:add_proto_expert_info(damaged, "The length octet does not fit the record")
    end
    return words .. ": " .. tostring(du(4):bytes():tohex(false, " "))
end

local function initiate(du, tree, is_request)
    if is_request then
        if du:len() < 6 then return nil end
        tree:add(f["pdu.send_timeout"], du(4, 2))
        if du:len() >= 12 then tree:add(f["pdu.features"], du(6, 6)) end
        return string.format("Send_Timeout %d ms", du(4, 2):uint() * 10)
    end
    if du:len() < 2 then return nil end
    tree:add(f["pdu.max_len"], du(1, 1))
    if du:len() >= 8 then tree:add(f["pdu.features"], du(2, 6)) end
    return string.format("records up to %d octets", du(1, 1):uint())
end

local function resource_manager(du, tree)
    if du:len() < 4 then return nil end
    tree:add(f["pdu.server_sap"], du(1, 1))
    tree:add(f["pdu.send_timeout"], du(2, 2))
    return string.format("connection on SAP %d", du(1, 1):uint())
end

local function abort(du, tree)
    if du:len() < 3 then return nil end
    tree:add(f["pdu.subnet"], du(1, 1))
    tree:add(f["pdu.reason"], du(2, 1))
    local reason = du(2, 1):uint()
    return ABORT[reason] or string.format("reason %02X", reason)
end

local function alarm_ack(du, tree)
    if du:len() < 4 then return nil end
    tree:add(f["pdu.slot"], du(1, 1))
    tree:add(f["pdu.alarm_type"], du(2, 1))
    tree:add(f["pdu.specifier"], du(3, 1))
    return string.format("slot %d, alarm type %d", du(1, 1):uint(), du(2, 1):uint())
end

local function negative(du, tree)
    if du:len() < 4 then return nil end
    tree:add(f["pdu.error_decode"], du(1, 1))
    tree:add(f["pdu.error_code_1"], du(2, 1))
    tree:add(f["pdu.error_code_2"], du(3, 1))
    local code = du(2, 1):uint()
    local words = string.format("refused: %s (%02X), %02X", ERROR_CODE[code] or "unknown", code, du(3, 1):uint())
    tree:add_proto_expert_info(refused, words)
    return words
end

local function acyclic(du, tree, is_request)
    if du:len() == 0 then return is_request and "poll" or nil end
    tree:add(f["pdu"], du(0, 1))
    tree:add(f["pdu.negative"], du(0, 1))
    local number = du(0, 1):uint()
    local name = PDU[number % 128] or string.format("function %02X", number)
    local words
    if number >= 128 then
        words = negative(du, tree)
    elseif number == 0x5E then
        words = record(du, tree, not is_request)
    elseif number == 0x5F then
        words = record(du, tree, is_request)
    elseif number == 0x51 then
        words = record(du, tree, true)
    elseif number == 0x57 then
        words = initiate(du, tree, is_request)
    elseif number == 0x56 then
        words = resource_manager(du, tree)
    elseif number == 0x58 then
        words = abort(du, tree)
    elseif number == 0x5C then
        words = alarm_ack(du, tree)
    elseif number == 0x48 then
        return name
    end
    if not words then
        tree:add_proto_expert_info(damaged, "The PDU is too short")
        return name
    end
    return name .. " " .. words
end

-- FDL --------------------------------------------------------------------------------------------------------------------

local function service_name(sap)
    if sap == nil then return "Data_Exchange" end
    if sap <= 48 then return "MS2 SAP " .. sap end
    return SERVICE[sap] or "SAP " .. sap
end

-- The description of the data unit; nil if its service has none. `format` is the format of the device-related blocks in a diagnosis.
local function data_unit(sap, du, tree, is_request, format)
    if sap == 60 and not is_request then return slave_diag(du, tree, format) end
    if sap == 61 and is_request then return set_prm(du, tree) end
    if sap == 62 and is_request or sap == 59 and not is_request then return configuration(du, tree) end
    if sap == 58 and is_request then return global_control(du, tree) end
    if sap == 55 and is_request then return set_slave_add(du, tree) end
    if sap ~= nil and sap <= 51 then return acyclic(du, tree, is_request) end
    return nil
end

local function frame_control(octet, tree)
    local item = tree:add(f["fc"], octet)
    local fc = octet:uint()
    local is_request = math.floor(fc / 64) % 2 == 1
    item:add(f["request"], octet)
    if is_request then
        item:add(f["fcb"], octet)
        item:add(f["fcv"], octet)
        item:add(f["function"], octet)
    else
        item:add(f["station"], octet)
        item:add(f["status"], octet)
    end
    return fc, is_request
end

local function count_words(fc)
    local fcb, fcv = math.floor(fc / 32) % 2, math.floor(fc / 16) % 2
    if fcv == 1 then return " FCB " .. fcb end
    return fcb == 1 and " first" or ""
end

-- Cycles -----------------------------------------------------------------------------------------------------------------

-- What the first pass over the packets finds: by packet number, the answer to a request, the request of an answer, the request that a
-- repetition repeats, the service that a refusal refuses, and whether a request was ended by another telegram without an answer.
local answer_of, request_of, repeats, service_of, silent = {}, {}, {}, {}, {}

-- The request that waits for its answer, the last request to each station, and whether damaged octets came since.
local pending, last_to, disturbed = nil, {}, {}

-- What the answers of each station show about DP-V1: the mode of its last Set_Prm ("V0", "V1"), whether it has DP-V1, its ident number. By packet
-- number, the format of the device-related blocks in a diagnosis. `crates/explain/src/dpv1.rs` has the rules.
local dpv1, block_format = {}, {}

function proto.init()
    answer_of, request_of, repeats, service_of, silent = {}, {}, {}, {}, {}
    pending, last_to, disturbed = nil, {}, {}
    dpv1, block_format = {}, {}
end

local function enter(known, mode)
    known.has_dpv1 = known.has_dpv1 or known.mode == "V1"
    known.mode = mode
end

-- Takes the answer to a request, with its status and its data unit.
local function learn_dpv1(number, request, code, du)
    local sap, is_refusal = request.dsap, code and (code >= 1 and code <= 3 or not STATUS[code])
    if sap == nil or is_refusal then return end
    local known = dpv1[request.da] or {}
    dpv1[request.da] = known
    if sap <= 49 then
        known.has_dpv1 = true
    elseif sap == 50 or sap == 51 then
        enter(known, "V1")
    elseif sap == 61 and request.prm and (code or 0) == 0 then
        enter(known, request.prm)
    elseif sap == 60 and du and du:len() >= 6 then
        local ident = du(4, 2):uint()
        if known.ident and known.ident ~= ident then
            known = {}
            dpv1[request.da] = known
        end
        known.ident = ident
        if math.floor(du(0, 1):uint() / 0x40) % 2 == 1 then known.mode = nil end
        if known.mode == "V1" or known.mode == nil and known.has_dpv1 then
            block_format[number] = "messages"
        elseif known.mode == "V0" and not known.has_dpv1 then
            block_format[number] = "vendor or module status"
        end
    end
end

-- The mode of a Set_Prm; nil for one that does not lock the slave. DP-V1 has three status octets; with reserved bits in them the octets
-- may be the vendor's, and the mode is unknown.
local function prm_mode(du)
    if du:len() < 7 or math.floor(du(0, 1):uint() / 0x40) ~= 2 then return nil end
    if du:len() < 10 or du(7, 1):uint() < 0x80 then return "V0" end
    local function bits(at, lowest, count) return math.floor(du(at, 1):uint() / lowest) % count end
    local has_reserved = bits(7, 0x08, 4) + bits(8, 0x02, 2) + bits(9, 0x20, 4) > 0
    return has_reserved and "unknown" or "V1"
end

-- A request without an answer ends with the next request or token.
local function end_pending()
    if pending then silent[pending.number] = true end
    pending = nil
end

-- Damaged octets may be the pending answer, or a request: then an equal frame count bit shows no repetition.
local function disturb(is_one_telegram)
    for station in pairs(last_to) do
        local is_answer = pending and pending.da == station and is_one_telegram and not disturbed[station]
        disturbed[station] = is_answer and "answer" or "requests"
    end
end

local function add_request(pinfo, request)
    end_pending()
    request.number = pinfo.number
    local last = last_to[request.da]
    if request.is_counted and last and last.key == request.key and disturbed[request.da] ~= "requests" then
        repeats[pinfo.number] = last.number
    end
    last_to[request.da], disturbed[request.da] = request, nil
    pending = request
end

-- An answer belongs to the pending request if addresses and access points are swapped. SC has none.
local function add_answer(pinfo, answer)
    if not pending then return end
    if answer then
        local stations = answer.sa == pending.da and answer.da == pending.sa
        local plain = answer.dsap == nil and answer.ssap == nil
        local saps = answer.ssap == pending.dsap and answer.dsap == pending.ssap
        local opens = pending.dsap ~= nil and pending.dsap <= 49 and answer.dsap == pending.ssap
        if not (stations and (plain or saps or opens)) then return end
    end
    learn_dpv1(pinfo.number, pending, answer and answer.code, answer and answer.du)
    answer_of[pending.number], request_of[pinfo.number] = pinfo.number, pending.number
    service_of[pinfo.number] = pending.service
    pending = nil
end

-- Shows what the first pass has found for this packet.
local function show_cycle(pinfo, tree)
    local number = pinfo.number
    if answer_of[number] then tree:add(f["response_in"], answer_of[number]):set_generated() end
    if request_of[number] then tree:add(f["request_in"], request_of[number]):set_generated() end
    if repeats[number] then
        tree:add(f["repeats"], repeats[number]):set_generated()
        tree:add_proto_expert_info(repetition, string.format("Repetition of the request in packet %d", repeats[number]))
        pinfo.cols.info:append(" (repetition)")
    end
    if silent[number] then
        tree:add_proto_expert_info(unanswered, "No answer to this request")
        pinfo.cols.info:append(" (no answer)")
    end
end

-- FDL telegrams ----------------------------------------------------------------------------------------------------------

-- Dissects DA up to the last octet before FCS.
local function frame(body, tree, pinfo)
    local da, sa = body(0, 1), body(1, 1)
    local extensions = math.floor(da:uint() / 128) + math.floor(sa:uint() / 128)
    if body:len() < 3 + extensions then return "an address extension is announced and missing" end
    tree:add(f["da"], da)
    tree:add(f["dae"], da)
    tree:add(f["sa"], sa)
    tree:add(f["sae"], sa)
    local fc, is_request = frame_control(body(2, 1), tree)
    local at, dsap, ssap = 3, nil, nil
    if da:uint() >= 128 then
        dsap = body(at, 1):uint()
        tree:add(f["dsap"], body(at, 1))
        at = at + 1
    end
    if sa:uint() >= 128 then
        ssap = body(at, 1):uint()
        tree:add(f["ssap"], body(at, 1))
        at = at + 1
    end
    pinfo.cols.src = tostring(sa:uint() % 128)
    pinfo.cols.dst = da:uint() % 128 == 127 and "all" or tostring(da:uint() % 128)
    local du = body:len() > at and body(at) or nil
    local code, words = fc % 16, nil
    local is_unanswered = is_request and (code == 4 or code == 6)
    if not pinfo.visited then
        local stations = { da = da:uint() % 128, sa = sa:uint() % 128, dsap = dsap, ssap = ssap }
        if is_unanswered then
            end_pending()
        elseif is_request then
            local is_status = code == 9 or code == 14 or code == 15
            stations.service = is_status and FUNCTION[code] or service_name(dsap)
            stations.key = tostring(body:bytes())
            stations.is_counted = math.floor(fc / 16) % 2 == 1
            stations.prm = dsap == 61 and du and prm_mode(du) or nil
            add_request(pinfo, stations)
        else
            stations.code, stations.du = code, du
            add_answer(pinfo, stations)
        end
    end
    if is_request and code ~= 3 and code ~= 4 and code ~= 5 and code ~= 6 and code ~= 12 and code ~= 13 then
        words = (FUNCTION[code] or string.format("request %02X", fc)) .. " ?"
    elseif not is_request and code == 0 then
        words = "OK, " .. STATION[math.floor(fc / 16) % 4]
    elseif not is_request and ssap == nil and du == nil then
        words = STATUS[code] or string.format("answer %02X", fc)
        if code == 1 or code == 2 or code == 3 then
            local service = service_of[pinfo.number]
            if service then tree:add(f["refused_service"], service):set_generated() end
            words = words .. ": refuses " .. (service or "a request that is not in the capture")
            tree:add_proto_expert_info(refused, words)
        end
    else
        local sap = dsap
        if not is_request then sap = ssap end
        local service = service_name(sap)
        tree:add(f["service"], service):set_generated()
        words = service .. (is_request and count_words(fc) or " " .. (STATUS[code] or string.format("%02X", fc)))
        local said
        if du then
            local item = tree:add(f["data"], du)
            said = data_unit(sap, du, item, is_request, block_format[pinfo.number])
            if not said then said = tostring(du:bytes():tohex(false, " ")) end
        elseif is_request and sap ~= nil and sap <= 51 then
            said = "poll"
        end
        if said then words = words .. " " .. said end
    end
    pinfo.cols.info = words
    show_cycle(pinfo, tree)
    return nil
end

-- The error of octets that are not a telegram; nil for a telegram.
local function defect(buffer)
    local first, length = buffer(0, 1):uint(), buffer:len()
    if not START[first] then return string.format("no telegram begins with %02X", first) end
    local wanted = ({ [0x10] = 6, [0xA2] = 14, [0xDC] = 3, [0xE5] = 1 })[first]
    if first == 0x68 then
        if length < 4 or buffer(1, 1):uint() ~= buffer(2, 1):uint() or buffer(3, 1):uint() ~= 0x68 then
            return "the length octets do not fit the telegram"
        end
        wanted = buffer(1, 1):uint() + 6
        if wanted < 9 or wanted > 255 then return "the length octets do not fit the telegram" end
    end
    if length ~= wanted then return string.format("%d octets instead of %d", length, wanted) end
    if length > 3 and buffer(length - 1, 1):uint() ~= 0x16 then
        return string.format("the telegram ends with %02X instead of 16", buffer(length - 1, 1):uint())
    end
    return nil
end

-- Whether damaged octets are at most one telegram: no longer than they announce, or shorter than a request.
local function is_one_telegram(buffer)
    local first, length = buffer(0, 1):uint(), buffer:len()
    local announced = ({ [0x10] = 6, [0xA2] = 14, [0xDC] = 3, [0xE5] = 1 })[first] or 5
    if first == 0x68 and length >= 4 and buffer(1, 1):uint() == buffer(2, 1):uint() and buffer(3, 1):uint() == 0x68 then
        announced = buffer(1, 1):uint() + 6
    end
    return length <= announced
end

-- What the check octet of a telegram sums up, and the sum.
local function body_and_sum(buffer)
    local from = buffer(0, 1):uint() == 0x68 and 4 or 1
    local body, sum = buffer(from, buffer:len() - from - 2), 0
    for at = 0, body:len() - 1 do sum = (sum + body(at, 1):uint()) % 256 end
    return body, sum
end

-- Whether octets can hardly be anything but a telegram. One octet E5 can.
local function is_certain(buffer)
    local first = buffer(0, 1):uint()
    if defect(buffer) or first == 0xE5 then return false end
    if first == 0xDC then return buffer(1, 1):uint() < 127 and buffer(2, 1):uint() < 127 end
    local _, sum = body_and_sum(buffer)
    return buffer(buffer:len() - 2, 1):uint() == sum
end

local function dissect(buffer, pinfo, root)
    if buffer:len() == 0 then return 0 end
    pinfo.cols.protocol = "PROFIBUS"
    pinfo.cols.src = ""
    pinfo.cols.dst = ""
    local tree = root:add(proto, buffer())
    local description = interface()
    if description and description.value:find("invented times", 1, true) then
        tree:add(f["invented_time"], true):set_generated()
        tree:add_proto_expert_info(invented, "The time of this packet is invented: its source has no times")
    end
    local sd = tree:add(f["sd"], buffer(0, 1))
    local wrong = defect(buffer)
    if wrong then
        sd:add_proto_expert_info(damaged, "Damaged: " .. wrong)
        pinfo.cols.info = "damaged: " .. wrong
        if not pinfo.visited then disturb(is_one_telegram(buffer)) end
        return buffer:len()
    end
    local first, length = buffer(0, 1):uint(), buffer:len()
    if first == 0xE5 then
        pinfo.cols.info = "SC"
        if not pinfo.visited then add_answer(pinfo, nil) end
        show_cycle(pinfo, tree)
        return length
    end
    if first == 0xDC then
        tree:add(f["da"], buffer(1, 1))
        tree:add(f["sa"], buffer(2, 1))
        pinfo.cols.src = tostring(buffer(2, 1):uint())
        pinfo.cols.dst = tostring(buffer(1, 1):uint())
        pinfo.cols.info = "Token"
        if not pinfo.visited then end_pending() end
        return length
    end
    if first == 0x68 then
        tree:add(f["le"], buffer(1, 1))
        tree:add(f["ler"], buffer(2, 1))
    end
    local body, sum = body_and_sum(buffer)
    local fcs = buffer(length - 2, 1)
    if fcs:uint() ~= sum then
        local words = string.format("the check octet is %02X, the sum is %02X", fcs:uint(), sum)
        tree:add(f["fcs"], fcs):add_proto_expert_info(damaged, "Damaged: " .. words)
        pinfo.cols.info = "damaged: " .. words
        if not pinfo.visited then disturb(true) end
        return length
    end
    wrong = frame(body, tree, pinfo)
    tree:add(f["fcs"], fcs)
    tree:add(f["ed"], buffer(length - 1, 1))
    if wrong then
        sd:add_proto_expert_info(damaged, "Damaged: " .. wrong)
        pinfo.cols.info = "damaged: " .. wrong
        if not pinfo.visited then disturb(true) end
    end
    return length
end

proto.dissector = dissect
DissectorTable.get("wtap_encap"):add(wtap.USER0, proto)

-- Wireshark has no name for LINKTYPE_PROFIBUS_DL (257): packets of pcapng files with it have the encapsulation 0, "unknown", as those
-- of every other link type without a name. So the first telegram must show that the file has PROFIBUS; damaged ones behind it are shown too.
local unnamed = Proto("profibus_dl", "PROFIBUS DP with a link type that Wireshark does not name")
local is_profibus = false

function unnamed.init()
    is_profibus = false
end

function unnamed.dissector(buffer, pinfo, root)
    if buffer:len() == 0 then return 0 end
    is_profibus = is_profibus or is_certain(buffer)
    if not is_profibus then return 0 end
    return dissect(buffer, pinfo, root)
end

DissectorTable.get("wtap_encap"):add(0, unnamed)
