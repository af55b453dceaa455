// A tone whose frequency the page holds in an element (palpate-tone, data-hz); browsers allow sound after a first click.
(() => {
  const state = (window.palpateTone = { hz: 0, volume: 0, sounding: false });
  let audio = null, oscillator = null, gain = null;
  window.addEventListener("pointerdown", () => {
    if (audio) return audio.resume();
    audio = new AudioContext();
    oscillator = audio.createOscillator();
    gain = audio.createGain();
    gain.gain.value = 0;
    oscillator.connect(gain).connect(audio.destination);
    oscillator.start();
  }, true);
  setInterval(() => {
    const element = document.getElementById("palpate-tone");
    state.hz = element ? Number(element.dataset.hz) || 0 : 0;
    state.volume = state.hz > 0 ? 0.15 : 0;
    state.sounding = audio !== null && audio.state === "running" && state.volume > 0;
    if (!audio) return;
    if (state.hz > 0) oscillator.frequency.setTargetAtTime(state.hz, audio.currentTime, 0.02);
    gain.gain.setTargetAtTime(state.volume, audio.currentTime, 0.02);
  }, 40);
})();
