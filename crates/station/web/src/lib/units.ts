// Units of pressure. Only the display uses them; the API and the recorder have Pa.

/** The size of each unit in Pa. */
export const UNITS = {
  mbar: 100,
  hPa: 100,
  Torr: 133.322368,
  micron: 0.133322368,
  Pa: 1,
} as const

export type Unit = keyof typeof UNITS

export const UNIT_NAMES = Object.keys(UNITS) as Unit[]

export function isUnit(text: string | null): text is Unit {
  return text !== null && text in UNITS
}

export function inUnit(pa: number, unit: Unit): number {
  return pa / UNITS[unit]
}

export function nextUnit(unit: Unit): Unit {
  return UNIT_NAMES[(UNIT_NAMES.indexOf(unit) + 1) % UNIT_NAMES.length] ?? unit
}

/** The sizes in Pa of the units in which the station's file has pressures, in small letters: case does not matter there. */
const FILE_UNITS: Record<string, number> = {
  mbar: 100,
  pa: 1,
  hpa: 100,
  kpa: 1e3,
  bar: 1e5,
  torr: 101_325 / 760,
  mtorr: 101.325 / 760,
  micron: 101.325 / 760,
}

/** The pressure in Pa that a text such as `1e-3 mbar` names; `null` if the station would refuse the text. */
export function pascals(text: string): number | null {
  const found = /^(\+?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)\s*([a-z]+)$/i.exec(text.trim())
  const pa = Number(found?.[1]) * (FILE_UNITS[found?.[2]?.toLowerCase() ?? ''] ?? Number.NaN)
  return Number.isFinite(pa) ? pa : null
}
