import { render } from 'preact'

render(<h1>profivac</h1>, document.getElementById('app')!)
