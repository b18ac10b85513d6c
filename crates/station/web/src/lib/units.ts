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
