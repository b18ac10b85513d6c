// Texts for the codes of the API.

import type {
  BusStatus,
  EventKind,
  Principle,
  Quality,
  Recorder,
  RiskClass,
  Segment,
  SegmentState,
} from '../api/types.ts'

export const BUS_STATUS: Record<BusStatus, { label: string; sentence: string }> = {
  'own-master': { label: 'our master', sentence: 'The master of this station.' },
  'other-master': { label: 'other master', sentence: 'Another master on the same bus.' },
  'data-exchange': { label: 'exchanging', sentence: 'A configured gauge in data exchange.' },
  fault: { label: 'fault', sentence: 'A configured gauge in data exchange that reports a fault.' },
  starting: { label: 'starting', sentence: 'A configured gauge that the master is bringing into data exchange.' },
  missing: {
    label: 'not exchanging',
    sentence: 'A configured gauge that does not answer, or that belongs to another master.',
  },
  unconfigured: { label: 'not configured', sentence: 'A slave that answers but is not in the station’s file.' },
}

export const QUALITIES: Record<Quality, string> = {
  valid: 'valid',
  overrange: 'over range',
  underrange: 'under range',
  fault: 'fault',
  stale: 'no data',
  off: 'off',
  missing: 'no gauge',
  assumed: 'assumed',
}

export const PRINCIPLES: Record<Principle, string> = {
  pirani: 'Pirani',
  'hot-cathode': 'hot cathode',
  'cold-cathode': 'cold cathode',
  diaphragm: 'diaphragm',
  atmosphere: 'atmosphere sensor',
}

export const SEGMENT_STATES: Record<SegmentState, string> = {
  waiting: 'waiting for the port',
  listening: 'listening on the bus',
  running: 'running',
}

export const EVENT_KINDS: Record<EventKind, string> = {
  station: 'Station',
  bus: 'Bus',
  gauge: 'Gauge',
  command: 'Command',
  note: 'Note',
  alarm: 'Alarm',
  access: 'Access',
  'pump-down': 'Pump-down',
}

export const RISKS: Record<RiskClass, { label: string; sentence: string }> = {
  harmless: { label: 'no risk named', sentence: 'The manual names no risk; relays may still switch.' },
  volatile: { label: 'volatile', sentence: 'The value is lost when the gauge loses power.' },
  'stored-on-request': {
    label: 'stored on request',
    sentence: 'The value survives a power loss after the gauge has stored it on request.',
  },
  persistent: { label: 'persistent', sentence: 'The value survives a power loss at once.' },
  dangerous: { label: 'risk', sentence: 'The text beside it describes the risk.' },
}

const GASES: Record<string, string> = { n2: 'N₂', h2: 'H₂', co2: 'CO₂', h2o: 'H₂O', o2: 'O₂', co: 'CO', air: 'air' }

export function gas(name: string): string {
  return GASES[name.toLowerCase()] ?? name.charAt(0).toUpperCase() + name.slice(1)
}

export function baud(bitsPerSecond: number): string {
  return bitsPerSecond >= 1e6 ? `${bitsPerSecond / 1e6} Mbit/s` : `${bitsPerSecond / 1e3} kbit/s`
}

/** The number of samples and events that the recorder lost, in one sentence; `null` if it lost none. */
export function lostSentence({ lost_samples, lost_events }: Recorder): string | null {
  const counted = (count: number, noun: string): string[] =>
    count ? [`${count} ${noun}${count === 1 ? '' : 's'}`] : []
  const all = [...counted(lost_samples, 'sample'), ...counted(lost_events, 'event')]
  return all.length ? `${all.join(' and ')} could not be recorded.` : null
}

/** The state of a segment, in one sentence. */
export function segmentSentence(segment: Segment): string {
  if (segment.problem) return `Not working: ${segment.problem}.`
  if (segment.state !== 'running') return `The segment is ${SEGMENT_STATES[segment.state]}.`
  const others = segment.stations.filter(({ state }) => ['missing', 'fault', 'starting'].includes(state))
  if (others.length === 0) return 'All gauges exchange data.'
  return `${others.map(({ name, address, description }) => `${name ?? address}: ${description}`).join('; ')}.`
}
