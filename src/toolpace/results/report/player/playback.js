// A time that is sought, and that runs while it is played; whoever watches is called at each.
class Playback {
  constructor(duration) {
    this.duration = duration;
    this.t = 0;
    this.rate = 1;
    this.watchers = [];
  }

  seek(t) {
    this.t = Math.min(Math.max(Number(t) || 0, 0), this.duration);
    for (const watch of this.watchers) watch(this.t);
  }

  play() {
    if (this.playing) return;
    if (this.t >= this.duration) this.seek(0);
    this.playing = true;
    let before = performance.now();
    const step = (now) => {
      this.seek(this.t + (this.rate * (now - before)) / 1e3);
      before = now;
      if (this.t >= this.duration) this.pause(); else if (this.playing) this.frame = requestAnimationFrame(step);
    };
    this.frame = requestAnimationFrame(step);
    for (const watch of this.watchers) watch(this.t);
  }

  pause() {
    // a frame that still came would play at twice the speed where it goes on at once
    cancelAnimationFrame(this.frame);
    this.playing = false;
    for (const watch of this.watchers) watch(this.t);
  }
}
