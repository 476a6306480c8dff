// render_glb.js - a frame of an exported model by a viewer that knows nothing of this project: three.js in headless Chromium.
//   node tests/app/render_glb.js MODEL.glb CAMERA WIDTHxHEIGHT OUT.png
// Needs chromium (apt), and three (npm install three) where NODE_PATH or a node_modules above finds it. The page sends its canvas
// back over a port of this machine, since what --screenshot takes is not of the size asked for.
const { spawn } = require('child_process'), fs = require('fs'), http = require('http'), os = require('os'), path = require('path');
const [model, camera, size, out] = process.argv.slice(2);
const [width, height] = size.split('x').map(Number);
const three = path.dirname(path.dirname(require.resolve('three')));
const PATIENCE = 120e3; // ms

const page = `<!doctype html><canvas id=c width=${width} height=${height}></canvas>
<script type=importmap>{"imports":{"three":"/three/build/three.module.js"}}</script>
<script type=module>
import * as THREE from 'three';
import { GLTFLoader } from '/three/examples/jsm/loaders/GLTFLoader.js';
try {
    const gltf = await new GLTFLoader().loadAsync('/model.glb');
    // The loader makes names differ, and keeps those of the file.
    const name = c => c.userData.name ?? c.parent?.userData.name ?? c.name;
    const eye = gltf.cameras.find(c => name(c) === ${JSON.stringify(camera)});
    if (!eye) throw Error('no such camera, but ' + gltf.cameras.map(name));
    const canvas = document.getElementById('c');
    const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    renderer.setSize(${width}, ${height}, false);
    renderer.setClearColor(0x9fb4c8);
    eye.aspect = ${width} / ${height};
    eye.updateProjectionMatrix();
    gltf.scene.updateMatrixWorld(true);
    renderer.render(gltf.scene, eye);
    canvas.toBlob(blob => fetch('/picture', { method: 'POST', body: blob }));
} catch (error) { fetch('/failure', { method: 'POST', body: String(error) }); }
</script>`;

let browser, folder;
function end(code, text) {
    if (text) console.error(text);
    if (browser) browser.kill('SIGKILL');
    server.close();
    setTimeout(() => { fs.rmSync(folder, { recursive: true, force: true }); process.exit(code); }, 300);
}

const TYPES = { '.js': 'text/javascript', '.html': 'text/html' };
const server = http.createServer((request, response) => {
    const name = request.url.split('?')[0];
    if (request.method === 'POST') {
        const parts = [];
        request.on('data', part => parts.push(part));
        request.on('end', () => {
            response.end();
            const body = Buffer.concat(parts);
            if (name !== '/picture') return end(1, String(body));
            fs.writeFileSync(out, body);
            end(0);
        });
        return;
    }
    const file = name.startsWith('/three/') ? path.join(three, path.normalize(name.slice(7))) : name === '/model.glb' ? model : null;
    response.setHeader('Content-Type', TYPES[path.extname(name)] || (file ? 'application/octet-stream' : 'text/html'));
    if (!file) return response.end(page);
    fs.createReadStream(file).on('error', () => { response.statusCode = 404; response.end(); }).pipe(response);
});

server.listen(0, '127.0.0.1', () => {
    folder = fs.mkdtempSync(path.join(os.tmpdir(), 'render-glb-'));
    browser = spawn('chromium', ['--headless', '--no-sandbox', '--disable-gpu-sandbox', '--use-angle=swiftshader',
        '--enable-unsafe-swiftshader', `--user-data-dir=${folder}`, `http://127.0.0.1:${server.address().port}/`], { stdio: 'ignore' });
    browser.on('error', error => end(1, String(error)));
    setTimeout(() => end(1, 'no picture in time'), PATIENCE);
});
