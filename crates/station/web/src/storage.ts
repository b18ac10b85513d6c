// Texts that the browser keeps. It may refuse: then they are gone when the page is closed.

export function read(name: string): string | null {
  try {
    return localStorage.getItem(name)
  } catch {
    return null
  }
}

export function write(name: string, text: string): void {
  try {
    localStorage.setItem(name, text)
  } catch {
    // See above.
  }
}
