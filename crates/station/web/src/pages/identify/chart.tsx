// The measured pressure beside fit and prediction, and the residuals below, over the same time.

import type { JSX } from 'preact'
import type { Plant } from '../../api/types.ts'
import { LogChart, PressureGrid, TimeGrid } from '../../components/log-chart.tsx'
import { axesOf, EARLIEST, line } from '../../lib/plant.ts'
import { type Axes, place } from '../../lib/pump-downs.ts'
import { useUnit } from '../../settings.ts'
import { t } from '../../texts/texts.ts'

/** The heights of the charts in pixels. */
const [HEIGHT, RESIDUAL_HEIGHT] = [392, 178]

/** The largest residual that is drawn, in standard deviations. */
const FAR = 4

export function PlantChart({ plant }: { plant: Plant }): JSX.Element | null {
  const unit = useUnit()
  const axes = axesOf(plant)
  if (!axes) return null
  const { prediction, residuals } = plant
  const edge = (of: 'low' | 'high') => prediction.map(({ s, pa }) => ({ s, pa: pa[of] ?? 10 ** axes.pa[1] }))
  const band = [...edge('high'), ...edge('low').reverse()]
  const fit = residuals.map(({ s, fitted_pa }) => ({ s, pa: fitted_pa }))
  const predicted = prediction.map(({ s, pa }) => ({ s, pa: pa.mean }))
  return (
    <figure class="panel">
      <figcaption class="legend">
        <span class="measured">● {t.identify.measured}</span> <span class="fit">━ {t.identify.fit}</span>{' '}
        <span class="predicted">╌ {t.identify.predicted}</span>
      </figcaption>
      <LogChart height={HEIGHT} label={t.identify.chart(plant.series, unit)}>
        {(width, height) => (
          <>
            <TimeGrid axes={axes} width={width} height={height} name={t.identify.seconds} />
            <PressureGrid axes={axes} width={width} height={height} />
            <polygon class="band" points={line(band, axes, width, height)} />
            {residuals
              .filter(({ s }) => s >= EARLIEST)
              .map(({ s, measured_pa }) => (
                <circle
                  key={s}
                  class="measured"
                  cx={place(s, axes.s) * width}
                  cy={(1 - place(measured_pa, axes.pa)) * height}
                  r={2}
                />
              ))}
            <polyline class="fit" points={line(fit, axes, width, height)} />
            <polyline class="predicted" points={line(predicted, axes, width, height)} />
          </>
        )}
      </LogChart>
    </figure>
  )
}

export function Residuals({ plant }: { plant: Plant }): JSX.Element | null {
  const axes = axesOf(plant)
  if (!axes) return null
  return (
    <figure class="panel">
      <figcaption>{t.identify.residuals}</figcaption>
      <LogChart height={RESIDUAL_HEIGHT} label={t.identify.residualsOf(plant.residuals.length)}>
        {(width, height) => <ResidualPoints plant={plant} axes={axes} width={width} height={height} />}
      </LogChart>
    </figure>
  )
}

interface PointsProps {
  plant: Plant
  axes: Axes
  width: number
  height: number
}

function ResidualPoints({ plant, axes, width, height }: PointsProps): JSX.Element {
  const y = (deviations: number): number => (0.5 - Math.max(-FAR, Math.min(FAR, deviations)) / FAR / 2) * height
  return (
    <>
      <TimeGrid axes={axes} width={width} height={height} name={t.identify.seconds} />
      {[-FAR, -2, 0, 2, FAR].map((deviations) => (
        <g key={deviations}>
          <line class={deviations === 0 ? 'zero' : 'grid'} x1={0} x2={width} y1={y(deviations)} y2={y(deviations)} />
          <text x={-6} y={y(deviations) + 4} text-anchor="end">
            {deviations}
          </text>
        </g>
      ))}
      {plant.residuals
        .filter(({ s }) => s >= EARLIEST)
        .map(({ s, deviations }) => (
          <circle key={s} class="measured" cx={place(s, axes.s) * width} cy={y(deviations)} r={2} />
        ))}
    </>
  )
}
