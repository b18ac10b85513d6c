// The words for what the API has as codes.

import type { EventKind, Principle, Quality, Recorder, RiskClass, Segment, SegmentState, Standing } from '../api.ts'

export const STANDINGS: Record<Standing, { word: string; sentence: string }> = {
  ourselves: { word: 'our master', sentence: 'The master of this station.' },
  master: { word: 'other master', sentence: 'A master that is not ours; it takes turns with us.' },
  exchanging: { word: 'exchanging', sentence: 'A gauge of ours that exchanges data.' },
  faulty: { word: 'fault', sentence: 'A gauge of ours that exchanges data and reports a fault.' },
  starting: { word: 'starting', sentence: 'A gauge of ours that is being brought into data exchange.' },
  missing: { word: 'missing', sentence: 'A gauge of ours that does not answer, or that another master has.' },
  foreign: { word: 'not ours', sentence: 'A slave that answers and does not stand in the station’s file.' },
}

export const QUALITIES: Record<Quality, string> = {
  valid: 'measures',
  overrange: 'over range',
  underrange: 'under range',
  invalid: 'not valid',
  gap: 'no data',
}

export const PRINCIPLES: Record<Principle, string> = {
  pirani: 'Pirani',
  'hot-cathode': 'hot cathode',
  'cold-cathode': 'cold cathode',
  diaphragm: 'diaphragm',
  atmosphere: 'atmosphere sensor',
}

export const STATES: Record<SegmentState, string> = {
  waiting: 'waits for its port',
  listening: 'listens before it takes the line',
  running: 'runs',
}

export const KINDS: Record<EventKind, string> = {
  station: 'Station',
  bus: 'Bus',
  gauge: 'Gauge',
  command: 'Command',
  note: 'Note',
  alarm: 'Alarm',
  access: 'Access',
}

export const RISKS: Record<RiskClass, string> = {
  harmless: 'harmless',
  volatile: 'volatile',
  'on-request': 'kept on request',
  kept: 'kept',
  dangerous: 'risk',
}

export const RISK_SENTENCES: Record<RiskClass, string> = {
  harmless: 'Nothing is lost by it.',
  volatile: 'Holds until the gauge is switched off.',
  'on-request': 'Outlives the power once it has been stored.',
  kept: 'Outlives the power at once.',
  dangerous: 'Beside it stands what can happen.',
}

const GASES: Record<string, string> = { n2: 'N₂', h2: 'H₂', co2: 'CO₂', h2o: 'H₂O', o2: 'O₂', co: 'CO', air: 'air' }

export function gas(name: string): string {
  return GASES[name.toLowerCase()] ?? name.charAt(0).toUpperCase() + name.slice(1)
}

export function baud(bitsPerSecond: number): string {
  const [value, unit] = bitsPerSecond >= 1e6 ? [bitsPerSecond / 1e6, 'Mbit/s'] : [bitsPerSecond / 1e3, 'kbit/s']
  return `${value} ${unit}`
}

/** What the recorder could not keep, in one sentence; nothing if it kept everything. */
export function lostSentence({ lost, lost_events }: Recorder): string | null {
  const many = (count: number, what: string): string[] => (count ? [`${count} ${what}${count === 1 ? '' : 's'}`] : [])
  const all = [...many(lost, 'sample'), ...many(lost_events, 'event')]
  return all.length ? `${all.join(' and ')} could not be recorded.` : null
}

/** How a segment is, in one sentence. */
export function segmentSentence(segment: Segment): string {
  if (segment.trouble) return `In trouble: ${segment.trouble}.`
  if (segment.state !== 'running') return `The segment ${STATES[segment.state]}.`
  const others = segment.stations.filter(({ standing }) => ['missing', 'faulty', 'starting'].includes(standing))
  if (others.length === 0) return 'All gauges exchange data.'
  return others.map((one) => `${one.name ?? one.address}: ${one.words}`).join('; ') + '.'
}
