// What pictures are drawn into: the canvas, or samples of its pixels.

// Give a canvas its pixels, in a scale to those of the screen; return how many a pixel of the page has.
function fill(canvas, scale) {
  const ratio = scale * Math.min(window.devicePixelRatio || 1, 2);
  if (!canvas.clientWidth) return ratio;  // it is not shown, as on paper
  const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((length) => Math.max(1, Math.round(length * ratio)));
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  return ratio;
}

class Target {
  constructor(gl) {
    Object.assign(this, { gl, key: "", buffer: gl.createFramebuffer(), parts: [] });
    this.most = gl.getParameter(gl.MAX_SAMPLES);
  }

  // Draw into so many samples of each pixel, or into the canvas if it is none.
  begin(samples) {
    const { gl } = this, size = [gl.drawingBufferWidth, gl.drawingBufferHeight];
    Object.assign(this, { samples, size });
    gl.bindFramebuffer(gl.FRAMEBUFFER, samples ? this.made(Math.min(samples, this.most)) : null);
    gl.viewport(0, 0, ...size);
    return size;
  }

  made(samples) {
    const { gl, buffer, size } = this, key = size.join();
    if (this.key === key) return buffer;
    for (const part of this.parts) gl.deleteRenderbuffer(part);
    gl.bindFramebuffer(gl.FRAMEBUFFER, buffer);
    this.key = key;
    this.parts = [[gl.COLOR_ATTACHMENT0, gl.RGBA8], [gl.DEPTH_ATTACHMENT, gl.DEPTH_COMPONENT24]].map(([place, kind]) => {
      const part = gl.createRenderbuffer();
      gl.bindRenderbuffer(gl.RENDERBUFFER, part);
      gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, kind, ...size);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, part);
      return part;
    });
    return buffer;
  }

  // Copy what was drawn to the canvas.
  end() {
    const { gl, buffer, size, samples } = this;
    if (!samples) return;
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, buffer);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null);
    gl.blitFramebuffer(0, 0, ...size, 0, 0, ...size, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }
}
