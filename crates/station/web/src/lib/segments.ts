// Segments of the bus map: their order, and the numbers of their stations.

import type { BusStation, BusStatus, Segment } from '../api/types.ts'

/** All station addresses; 126 is the address of a slave that has none yet. */
export const ADDRESSES = Array.from({ length: 127 }, (_, address) => address)

/** How soon a user must look at a segment; 0 if it has no problem. A gauge that starts is no problem: it would move its segment twice. */
function urgency({ problem, state, stations }: Segment): number {
  if (problem) return 3
  const has = (...wanted: BusStatus[]): boolean => stations.some(({ state }) => wanted.includes(state))
  if (has('missing', 'fault')) return 2
  return Number(state !== 'running' || has('unconfigured'))
}

/** The segments with a problem first; those that are equal stay in the order of the station's file. */
export const problemsFirst = (segments: Segment[]): Segment[] =>
  [...segments].sort((one, other) => urgency(other) - urgency(one))

/** The number of stations with a bus status. */
export const countOf = (stations: BusStation[], status: BusStatus): number =>
  stations.filter(({ state }) => state === status).length

/** The number of addresses without a station. */
export const freeAddresses = ({ stations }: Segment): number =>
  ADDRESSES.length - new Set(stations.map(({ address }) => address)).size
