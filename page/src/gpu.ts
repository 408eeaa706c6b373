// Draws the points with WebGL2, where there is hardware for it: software WebGL takes a second for what the CPU path does
// in some 30 ms, and is refused. Poses are a texture, so that a new map is a few kilobytes.

import type { View } from "./worker";

const VERTEX = `#version 300 es
layout(location = 0) in vec2 point;
layout(location = 1) in float pose;
uniform highp sampler2D poses;
uniform vec2 centre, scale;
uniform float size;
void main() {
  int i = int(pose);
  vec4 p = texelFetch(poses, ivec2(i & 1023, i >> 10), 0);
  vec2 q = vec2(p.z * point.x - p.w * point.y, p.w * point.x + p.z * point.y) + p.xy;
  gl_Position = vec4((q - centre) * scale, 0.0, 1.0);
  gl_PointSize = size;
}`;
const FRAGMENT = `#version 300 es
precision mediump float;
uniform vec4 colour;
out vec4 result;
void main() { result = vec4(colour.rgb * colour.a, colour.a); }`;

/** What a point hides of what is under it: walls, seen often, become solid. */
const OPACITY = 0.55;

/** True if the browser draws WebGL2 on a GPU rather than in software. */
export function hasGpu(): boolean {
  const gl = new OffscreenCanvas(1, 1).getContext("webgl2", { failIfMajorPerformanceCaveat: true });
  if (!gl) return false;
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const name = String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  return !/swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

export class Gpu {
  private readonly at: Record<string, WebGLUniformLocation | null> = {};
  private readonly textures = new Map<string, WebGLTexture>();
  private readonly all: WebGLVertexArrayObject;
  private readonly few: WebGLVertexArrayObject;
  private fewBuffer: WebGLBuffer | null = null;
  private count = 0;

  private constructor(private readonly gl: WebGL2RenderingContext) {
    [this.all, this.few] = [gl.createVertexArray(), gl.createVertexArray()];
  }

  static on(canvas: OffscreenCanvas): Gpu | null {
    const gl = canvas.getContext("webgl2", { antialias: false, depth: false, premultipliedAlpha: true });
    if (!gl) return null;
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]] as const) {
      const shader = gl.createShader(kind)!;
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return null;
    gl.useProgram(program);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    const gpu = new Gpu(gl);
    for (const name of ["poses", "centre", "scale", "size", "colour"]) gpu.at[name] = gl.getUniformLocation(program, name);
    return gpu;
  }

  /** x, y and the index of its pose for every point: of all, or of those named. */
  private buffer(array: WebGLVertexArrayObject, starts: Uint32Array, points: Float32Array, indices: Uint32Array | null): WebGLBuffer {
    const { gl } = this, n = indices ? indices.length : points.length / 2;
    const data = new Float32Array(3 * n);
    let pose = 0;
    for (let k = 0; k < n; k++) {
      const point = indices ? indices[k] : k;
      while (point >= starts[pose + 1]) pose++;
      data[3 * k] = points[2 * point];
      data[3 * k + 1] = points[2 * point + 1];
      data[3 * k + 2] = pose;
    }
    const buffer = gl.createBuffer();
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, indices ? gl.STREAM_DRAW : gl.STATIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 12, 0);
    gl.enableVertexAttribArray(1);
    gl.vertexAttribPointer(1, 1, gl.FLOAT, false, 12, 8);
    return buffer;
  }

  points(starts: Uint32Array, points: Float32Array): void {
    this.count = points.length / 2;
    this.buffer(this.all, starts, points, null);
  }

  poses(name: string, poses: Float64Array | null): void {
    const { gl } = this, old = this.textures.get(name);
    if (old) { gl.deleteTexture(old); this.textures.delete(name); }
    if (!poses) return;
    const rows = Math.max(1, Math.ceil(poses.length / 3 / 1024)), data = new Float32Array(4096 * rows);
    for (let i = 0; 3 * i < poses.length; i++) data.set([poses[3 * i], poses[3 * i + 1], Math.cos(poses[3 * i + 2]), Math.sin(poses[3 * i + 2])], 4 * i);
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, 1024, rows, 0, gl.RGBA, gl.FLOAT, data);
    for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, side, gl.NEAREST);
    this.textures.set(name, texture);
  }

  begin(width: number, height: number): void {
    this.gl.viewport(0, 0, width, height);
    this.gl.clearColor(0, 0, 0, 0);
    this.gl.clear(this.gl.COLOR_BUFFER_BIT);
  }

  private draw(array: WebGLVertexArrayObject, count: number, poses: string, [r, g, b]: [number, number, number], alpha: number, size: number, view: View): void {
    const { gl, at } = this, texture = this.textures.get(poses);
    if (!texture || count === 0) return;
    gl.bindVertexArray(array);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.uniform2f(at["centre"], view.x, view.y);
    gl.uniform2f(at["scale"], (2 * view.scale) / view.width, (2 * view.scale) / view.height);
    gl.uniform1f(at["size"], size);
    gl.uniform4f(at["colour"], r / 255, g / 255, b / 255, alpha);
    gl.drawArrays(gl.POINTS, 0, count);
  }

  layer(poses: string, rgb: [number, number, number], alpha: number, size: number, view: View): void {
    this.draw(this.all, this.count, poses, rgb, OPACITY * alpha, size, view);
  }

  light(poses: string, starts: Uint32Array, points: Float32Array, indices: Uint32Array, rgb: [number, number, number], size: number, view: View): void {
    this.gl.deleteBuffer(this.fewBuffer);
    this.fewBuffer = this.buffer(this.few, starts, points, indices);
    this.draw(this.few, indices.length, poses, rgb, 1, size, view);
  }
}
