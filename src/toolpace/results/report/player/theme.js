// Dark or light: as the system has it, or as the button says; paper is light.
function currentLook() {
  const style = getComputedStyle(document.documentElement), of = (name) => style.getPropertyValue(name).trim();
  return { ink: of("--ink"), soft: of("--soft"), line: of("--line"), ground: of("--plot"), good: of("--good"), bad: of("--bad"),
    accent: of("--accent"), neutral: of("--neutral"), veil: of("--veil"), onBar: of("--on-bar"), second: of("--second"),
    bars: ["--bar-1", "--bar-2", "--bar-3", "--bar-4"].map(of), font: getComputedStyle(document.body).fontFamily };
}

// Calls `repaint` whenever the colours have changed; what is drawn by style sheets alone needs none.
function watchTheme(repaint = () => {}) {
  const root = document.documentElement, system = matchMedia("(prefers-color-scheme: dark)");
  const dress = (name) => {
    if (name) root.dataset.theme = name; else delete root.dataset.theme;
    repaint();
  };
  for (const button of document.querySelectorAll('[data-do="theme"]')) {
    button.addEventListener("click", () => dress((root.dataset.theme ? root.dataset.theme === "dark" : system.matches) ? "light" : "dark"));
  }
  system.addEventListener("change", repaint);
  let shown;
  window.addEventListener("beforeprint", () => { shown = root.dataset.theme; dress("light"); });
  window.addEventListener("afterprint", () => dress(shown));
}
