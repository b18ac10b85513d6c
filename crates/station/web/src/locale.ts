// A language for browsers without one: WebKit in a kiosk with LANG=C calls its language "C", which no Intl accepts, and the chart library
// asks for it while it is loaded. This module is imported first.

try {
  new Intl.NumberFormat(navigator.language)
} catch {
  Object.defineProperty(navigator, 'language', { value: 'en', configurable: true })
}
