import { render } from 'preact'
import { App } from './app.tsx'
import { start } from './live.ts'
import { whoami } from './session.ts'
import { applyTheme } from './settings.ts'
import './styles/base.css'
import './styles/pages.css'
import './styles/alarms.css'

applyTheme()
start()
void whoami()
render(<App />, document.getElementById('app')!)
