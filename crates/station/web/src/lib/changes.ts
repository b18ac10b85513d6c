// A state and its changes, as the live streams send them.

/** The entries with those of a change; `null` removes one. */
function withEntries<T>(entries: Record<string, T>, change: Record<string, T | null>): Record<string, T> {
  const made = new Map(Object.entries(entries))
  for (const [name, entry] of Object.entries(change)) {
    if (entry === null) made.delete(name)
    else made.set(name, entry)
  }
  return Object.fromEntries(made)
}

/**
 * The state after a change, which has whole parts, and of the parts `byName` the entries that have changed. The old state stays as it is,
 * and an entry without a change stays the same object.
 */
export function changed<T extends object, K extends keyof T>(state: T, change: Partial<T>, byName: K[]): T {
  const made = { ...state, ...change }
  for (const name of byName) {
    const [entries, changes] = [state[name], change[name]]
    if (changes) made[name] = withEntries(entries as Record<string, unknown>, changes) as T[K]
  }
  return made
}
