// The measured pressure beside fit and prediction, and the residuals below, over the same time.

import type { JSX } from 'preact'
import type { Plant } from '../../api/types.ts'
import { decade } from '../../lib/format.ts'
import { axesOf, EARLIEST, line } from '../../lib/plant.ts'
import { type Axes, decadesOf, place } from '../../lib/pump-downs.ts'
import { inUnit, UNITS } from '../../lib/units.ts'
import { useUnit } from '../../settings.ts'
import { t } from '../../texts/texts.ts'

/** The size of the charts, and of their margins. */
const [WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM] = [760, 392, 56, 24, 12, 40]
const RESIDUAL_HEIGHT = 162

/** The largest residual that is drawn, in standard deviations. */
const FAR = 4

export function PlantChart({ plant }: { plant: Plant }): JSX.Element | null {
  const unit = useUnit()
  const axes = axesOf(plant)
  if (!axes) return null
  const [width, height] = [WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM]
  const [from, to] = axes.pa.map((exponent) => Math.log10(inUnit(10 ** exponent, unit))) as [number, number]
  const marks = decadesOf([Math.ceil(from - 1e-9), Math.floor(to + 1e-9)])
  const { prediction, residuals } = plant
  const edge = (of: 'low' | 'high') => prediction.map(({ s, pa }) => ({ s, pa: pa[of] ?? 10 ** axes.pa[1] }))
  const band = [...edge('high'), ...edge('low').reverse()]
  const fit = residuals.map(({ s, fitted_pa }) => ({ s, pa: fitted_pa }))
  return (
    <figure class="panel">
      <figcaption>
        <span class="measured">● {t.identify.measured}</span> <span class="fit">━ {t.identify.fit}</span>{' '}
        <span class="predicted">╌ {t.identify.predicted}</span>
      </figcaption>
      <svg viewBox={`0 0 ${WIDTH} ${HEIGHT}`} role="img" aria-label={t.identify.chart(plant.series, unit)}>
        <g transform={`translate(${LEFT} ${TOP})`}>
          <TimeGrid axes={axes} width={width} height={height} />
          {marks.map((exponent) => {
            const y = (1 - place(UNITS[unit] * 10 ** exponent, axes.pa)) * height
            return (
              <g key={exponent}>
                <line class="grid" x1={0} x2={width} y1={y} y2={y} />
                <text x={-6} y={y + 4} text-anchor="end">
                  {decade(10 ** exponent)}
                </text>
              </g>
            )
          })}
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
          <polyline
            class="predicted"
            points={line(
              prediction.map(({ s, pa }) => ({ s, pa: pa.mean })),
              axes,
              width,
              height,
            )}
          />
        </g>
      </svg>
    </figure>
  )
}

export function Residuals({ plant }: { plant: Plant }): JSX.Element | null {
  const axes = axesOf(plant)
  if (!axes) return null
  const [width, height] = [WIDTH - LEFT - RIGHT, RESIDUAL_HEIGHT - TOP - BOTTOM]
  const y = (deviations: number): number => (0.5 - Math.max(-FAR, Math.min(FAR, deviations)) / FAR / 2) * height
  return (
    <figure class="panel">
      <figcaption>{t.identify.residuals}</figcaption>
      <svg
        viewBox={`0 0 ${WIDTH} ${RESIDUAL_HEIGHT}`}
        role="img"
        aria-label={t.identify.residualsOf(plant.residuals.length)}
      >
        <g transform={`translate(${LEFT} ${TOP})`}>
          <TimeGrid axes={axes} width={width} height={height} />
          {[-FAR, -2, 0, 2, FAR].map((deviations) => (
            <g key={deviations}>
              <line
                class={deviations === 0 ? 'zero' : 'grid'}
                x1={0}
                x2={width}
                y1={y(deviations)}
                y2={y(deviations)}
              />
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
        </g>
      </svg>
    </figure>
  )
}

function TimeGrid({ axes, width, height }: { axes: Axes; width: number; height: number }): JSX.Element {
  return (
    <>
      {decadesOf(axes.s).map((exponent) => {
        const x = place(10 ** exponent, axes.s) * width
        return (
          <g key={`s${exponent}`}>
            <line class="grid" x1={x} x2={x} y1={0} y2={height} />
            <text x={x} y={height + 16} text-anchor="middle">
              {decade(10 ** exponent)}
            </text>
          </g>
        )
      })}
      <text x={width / 2} y={height + 32} text-anchor="middle">
        {t.identify.seconds}
      </text>
    </>
  )
}
