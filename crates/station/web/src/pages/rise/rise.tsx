// Rate of rise: the valve to the pump is closed, the pressure rises, and a fit separates a leak from outgassing.

import './rise.css'
import type { JSX } from 'preact'
import { fitRise } from '../../api/calls.ts'
import { useQuery } from '../../components/hooks.ts'
import { allSeries } from '../../components/use-trends.ts'
import { useLive, useSnapshot } from '../../live.ts'
import { Link } from '../../router.tsx'
import { t } from '../../texts/texts.ts'
import { RiseChart } from './chart.tsx'
import { useMeasurement } from './measurement.ts'
import { Result } from './result.tsx'
import { Steps } from './steps.tsx'

/** A measurement that goes on is fitted this often. */
const REFRESH_MS = 2_000

export function RateOfRise(): JSX.Element {
  const live = useLive()
  const names = allSeries(useSnapshot().gauges).map(({ series }) => series)
  const [measurement, change] = useMeasurement(names[0] ?? '')
  const { series, begin, end, litres, gauge } = measurement
  const percent = measurement.accuracy === '' ? null : Number(measurement.accuracy)
  const volume = Number(litres) > 0 ? Number(litres) / 1000 : null
  const isReady = begin !== null && (end ?? live.now) > begin
  const period = isReady && end === null ? REFRESH_MS : null
  const query = useQuery(JSON.stringify(measurement), period, async () =>
    isReady
      ? fitRise({
          series,
          from: begin,
          to: Math.round(end ?? live.now),
          gauge,
          ...(volume === null ? {} : { volume_m3: volume }),
          ...(percent === null ? {} : { accuracy: percent / 100 }),
        })
      : null,
  )
  const fit = isReady ? query.value : null
  return (
    <div class="rise">
      <h1>{t.pages['/rise']}</h1>
      <p>
        {t.rise.identify((text) => (
          <Link to={`/rise/identify?series=${encodeURIComponent(series)}`}>{text}</Link>
        ))}
      </p>
      <Steps names={names} measurement={measurement} change={change} />
      <RiseChart measurement={measurement} fit={fit} select={(begin, end) => change({ ...measurement, begin, end })} />
      <Result fit={fit} isReady={isReady} gauge={gauge} query={query} />
    </div>
  )
}
