"use strict";
// One clock for everything on the page; it plays the videos and keeps them in step.

const FRAME_RATE = 30; // of the videos
const MAX_DRIFT = 0.12; // s; a video that is off by more is set to the clock

// Between two actions, show the first frame of the later one; times are rounded.
function nextFrame(time) {
  return (Math.floor(time * FRAME_RATE + 0.02) + 1.5) / FRAME_RATE;
}

class Clock {
  constructor(listener) {
    this.listener = listener;
    this.time = 0;
    this.duration = 0;
    this.rate = 1;
    this.playing = false;
    this.videos = [];
    this.last = null;
  }

  load(duration, videos) {
    this.pause();
    this.duration = duration;
    this.videos = videos;
    this.seek(Math.min(this.time, duration));
  }

  play() {
    if (this.playing || !this.duration) return;
    if (this.time >= this.duration - 1e-3) this.seek(0);
    this.playing = true;
    this.last = null;
    for (const video of this.videos) this.roll(video);
    requestAnimationFrame((now) => this.tick(now));
    this.listener();
  }

  pause() {
    this.playing = false;
    for (const video of this.videos) video.pause();
    this.listener();
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  seek(time) {
    this.time = Math.max(0, Math.min(time, this.duration));
    for (const video of this.videos) {
      video.currentTime = nextFrame(this.time);
      if (this.playing) this.roll(video);
    }
    this.listener();
  }

  setRate(rate) {
    this.rate = rate;
    for (const video of this.videos) video.playbackRate = rate;
  }

  roll(video) {
    video.playbackRate = this.rate;
    // A video at its end keeps its last frame. A pause may reject an earlier play(), which is no error.
    if (!(video.currentTime >= video.duration)) video.play().catch(() => {});
  }

  tick(now) {
    if (!this.playing) return;
    const passed = this.last === null ? 0 : ((now - this.last) / 1000) * this.rate;
    this.last = now;
    // Wait for videos that are still loading.
    const waiting = this.videos.some((video) => video.readyState < 2 && !video.error);
    if (!waiting) this.time = Math.min(this.time + passed, this.duration);
    for (const video of this.videos) {
      const over = video.currentTime >= video.duration;
      if (!over && !video.seeking && Math.abs(video.currentTime - this.time) > MAX_DRIFT * Math.max(1, this.rate)) {
        video.currentTime = this.time;
      }
    }
    if (this.time >= this.duration) {
      this.pause();
      this.seek(this.duration); // the videos are a few frames behind, and the last one shows the result
    } else {
      this.listener();
      requestAnimationFrame((next) => this.tick(next));
    }
  }
}
