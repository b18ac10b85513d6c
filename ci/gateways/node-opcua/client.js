// node-opcua against the OPC UA gateway: node client.js URL USER PASSWORD FOLDER
//
// The script reads, browses, subscribes, reads history and is refused when it writes; then it connects with Basic256Sha256, as a user,
// and lists the alarms. It ends with 1 and a sentence at the first difference.

import { strict as assert } from 'node:assert'
import { existsSync, mkdirSync, readdirSync, renameSync } from 'node:fs'
import path from 'node:path'
import certificates from 'node-opcua-certificate-manager'
import opcua from 'node-opcua-client'

const {
  AttributeIds,
  ClientMonitoredItem,
  ClientSubscription,
  DataType,
  MessageSecurityMode,
  OPCUAClient,
  SecurityPolicy,
  StatusCodes,
  TimestampsToReturn,
  UserTokenType,
  installAlarmMonitoring,
  uninstallAlarmMonitoring,
} = opcua
const { OPCUACertificateManager } = certificates

const [url, user, password, folder] = process.argv.slice(2)
const NAMESPACE = 'urn:profivac:station'
const HANG_MS = 60_000

const strategy = { initialDelay: 200, maxRetry: 1, maxDelay: 500 }

async function namespaceOf(session) {
  const names = await session.readNamespaceArray()
  const index = names.indexOf(NAMESPACE)
  assert.ok(index > 0, `no ${NAMESPACE} in ${names}`)
  return (id) => `ns=${index};s=${id}`
}

async function readValues(session, id) {
  const data = await session.read({ nodeId: id('gauge/chamber/pressure'), attributeId: AttributeIds.Value })
  assert.equal(data.statusCode, StatusCodes.Good)
  assert.ok(data.value.dataType === DataType.Float && data.value.value > 0.08 && data.value.value < 0.12, data.toString())
  assert.ok(Math.abs(Date.now() - data.sourceTimestamp.getTime()) < HANG_MS, 'the time of the reading')
  const path = await session.browse({ nodeId: id('gauge/chamber/pressure'), resultMask: 63, nodeClassMask: 0 })
  const properties = Object.fromEntries(path.references.map((it) => [it.browseName.name, it.nodeId]))
  const unit = await session.read({ nodeId: properties.EngineeringUnits, attributeId: AttributeIds.Value })
  assert.equal(unit.value.value.unitId, 5259596, 'UNECE PAL')
  const range = await session.read({ nodeId: properties.EURange, attributeId: AttributeIds.Value })
  assert.ok(range.value.value.low < 1e-5 && range.value.value.high > 1e4)
}

async function browseAll(session) {
  const seen = new Set()
  const waiting = ['ns=0;i=85']
  while (waiting.length > 0) {
    const nodeId = waiting.pop()
    if (seen.has(nodeId)) continue
    seen.add(nodeId)
    const found = await session.browse({ nodeId, referenceTypeId: 'ns=0;i=33', includeSubtypes: true, browseDirection: 0, resultMask: 63, nodeClassMask: 0 })
    assert.equal(found.statusCode, StatusCodes.Good, nodeId)
    waiting.push(...found.references.map((it) => it.nodeId.toString()))
  }
  return seen.size
}

async function subscribe(session, id) {
  const subscription = ClientSubscription.create(session, { requestedPublishingInterval: 100, publishingEnabled: true, requestedLifetimeCount: 600, requestedMaxKeepAliveCount: 10 })
  const item = ClientMonitoredItem.create(
    subscription,
    { nodeId: id('station/heartbeat'), attributeId: AttributeIds.Value },
    { samplingInterval: 100, discardOldest: true, queueSize: 4 },
    TimestampsToReturn.Both,
  )
  const values = []
  await new Promise((resolve, reject) => {
    setTimeout(() => reject(new Error('no three updates of the heartbeat')), HANG_MS).unref()
    item.on('changed', (data) => {
      values.push(Number(data.value.value[1] ?? data.value.value))
      if (values.length === 3) resolve()
    })
  })
  assert.ok(values[0] < values[1] && values[1] < values[2], `the heartbeat rises: ${values}`)
  await subscription.terminate()
}

async function readHistory(session, id) {
  const now = Date.now()
  const [found] = [await session.readHistoryValue(id('gauge/chamber/pressure'), new Date(now - 3_600_000), new Date(now))]
  const values = found.historyData.dataValues
  const times = values.map((it) => it.sourceTimestamp.getTime())
  assert.ok(values.length > 0 && times.every((time, index) => index === 0 || times[index - 1] <= time), 'history in order')
}

async function write(session, id) {
  const status = await session.write({
    nodeId: id('gauge/chamber/pressure'),
    attributeId: AttributeIds.Value,
    value: { value: { dataType: DataType.Float, value: 1 } },
  })
  assert.ok([StatusCodes.BadNotWritable, StatusCodes.BadUserAccessDenied].includes(status), status.toString())
}

async function open() {
  const client = OPCUAClient.create({ endpointMustExist: false, connectionStrategy: strategy })
  await client.connect(url)
  const session = await client.createSession()
  const id = await namespaceOf(session)
  await readValues(session, id)
  const nodes = await browseAll(session)
  await subscribe(session, id)
  await readHistory(session, id)
  await write(session, id)
  await session.close()
  await client.disconnect()
  return nodes
}

/** The list of alarms that node-opcua makes from events and a refresh; a viewer acknowledges nothing. */
async function alarms(session) {
  const list = await installAlarmMonitoring(session)
  const found = () => list.alarms().find((it) => it.fields.conditionName.value === 'Chamber high')
  await new Promise((resolve, reject) => {
    const end = setTimeout(() => reject(new Error('no alarm in the list')), HANG_MS)
    const poll = setInterval(() => {
      if (!found()) return
      clearInterval(poll)
      clearTimeout(end)
      resolve()
    }, 50)
    poll.unref()
  })
  const { fields, conditionId, eventId } = found()
  assert.equal(fields.ackedState.id.value, false, 'the alarm waits for an acknowledgement')
  assert.equal(fields.activeState.id.value, false, 'the alarm has ended')
  assert.equal(fields.severity.value, 800)
  const status = await session.acknowledgeCondition(conditionId, eventId, 'seen')
  assert.equal(status, StatusCodes.BadUserAccessDenied)
  await uninstallAlarmMonitoring(session)
}

/** A connection with Basic256Sha256 that logs in and reads. */
async function secured() {
  const rootFolder = path.join(folder, 'node-opcua')
  const clientCertificateManager = new OPCUACertificateManager({ rootFolder, automaticallyAcceptUnknownCertificate: true })
  await clientCertificateManager.initialize()
  const client = OPCUAClient.create({
    applicationName: 'node-opcua-test',
    applicationUri: 'urn:test:node-opcua',
    clientCertificateManager,
    securityMode: MessageSecurityMode.SignAndEncrypt,
    securityPolicy: SecurityPolicy.Basic256Sha256,
    endpointMustExist: false,
    connectionStrategy: strategy,
  })
  try {
    await client.connect(url)
    const session = await client.createSession({ type: UserTokenType.UserName, userName: user, password })
    const id = await namespaceOf(session)
    await readValues(session, id)
    await alarms(session)
    await session.close()
  } finally {
    await client.disconnect()
  }
}

async function main() {
  const nodes = await open()
  console.log(`node-opcua: ${nodes} nodes, values, subscription, history, a refused write`)
  if (!user) return
  const rejected = path.join(folder, 'plant.opcua', 'rejected')
  const trusted = path.join(folder, 'plant.opcua', 'trusted')
  const before = new Set(existsSync(rejected) ? readdirSync(rejected) : [])
  await assert.rejects(secured(), 'an unknown certificate was accepted')
  const unknown = readdirSync(rejected).filter((name) => !before.has(name))
  assert.equal(unknown.length, 1, `one rejected certificate, not ${unknown}`)
  mkdirSync(trusted, { recursive: true })
  renameSync(path.join(rejected, unknown[0]), path.join(trusted, unknown[0]))
  await secured()
  console.log('node-opcua: Basic256Sha256 with a trusted certificate and a user, the list of alarms')
}

main().then(
  () => process.exit(0),
  (error) => {
    console.error(error)
    process.exit(1)
  },
)
