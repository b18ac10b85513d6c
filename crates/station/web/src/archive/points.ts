// The points of slaves of several stations: which the archive has, and their trends.

import { getFrom } from '../api/request.ts'
import type { PointTrend } from '../api/types.ts'
import { type Query, useQuery } from '../components/hooks.ts'
import type { PointTrendSource } from '../components/use-trends.ts'
import { type StationPoint, stationPoints } from '../lib/point-trends.ts'
import type { ArchivedPoint } from './types.ts'

/** A new point appears after this time at the latest. */
const REFRESH_MS = 60_000

export function useStationPoints(): Query<StationPoint[]> {
  return useQuery('points', REFRESH_MS, async (signal) =>
    stationPoints(await getFrom<ArchivedPoint[]>('/api/points', signal)),
  )
}

/** The trend of a point of a station. Its slave has the name of the station before it, as a series has. */
export const archivedPointTrend: PointTrendSource<StationPoint> = async (point, from, to, pixels, signal) => {
  const { station, slave, name } = point
  const query = { station, slave, point: name, from: `${from}`, to: `${to}`, pixels: `${pixels}` }
  const trend = await getFrom<PointTrend>(`/api/point-trend?${new URLSearchParams(query)}`, signal)
  return { ...trend, point: { ...trend.point, slave: `${station}/${slave}` } }
}
