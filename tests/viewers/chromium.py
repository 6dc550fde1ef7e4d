"""Headless Chromium without a network, driven by Selenium; and what is asked of a page in it."""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--window-size=1400,900"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    "--host-resolver-rules=MAP * ~NOTFOUND",  # nothing is reached, whatever a page asks for
)
BROWSERS, DRIVERS = ("chromium", "google-chrome", "chrome"), ("chromedriver",)
# Fulfilled when the page has drawn what it was asked to draw.
DRAWN = "const done = arguments[arguments.length - 1]; requestAnimationFrame(() => setTimeout(() => done(true)));"
MODEL = "Bokeh.documents[0].get_model_by_name(arguments[0])"


def program(names: tuple[str, ...]) -> str | None:
    """Return the first of some programs that is there."""
    return next(filter(None, map(shutil.which, names)), None)


def missing() -> str:
    """Return what is missing for a test in Chromium; empty where nothing is."""
    try:
        import selenium  # noqa: F401
    except ImportError:
        return "needs Selenium: pip install selenium"
    if program(BROWSERS) and program(DRIVERS):
        return ""
    return "needs Chromium and its driver: on Debian 'apt-get install chromium chromium-driver'"


@contextmanager
def chromium() -> Iterator[Any]:
    """Start a browser with a profile of its own, and end it."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    with TemporaryDirectory() as profile:
        options = webdriver.ChromeOptions()
        options.binary_location = program(BROWSERS)
        for flag in (*FLAGS, f"--user-data-dir={profile}"):
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        driver = webdriver.Chrome(options=options, service=Service(executable_path=program(DRIVERS)))
        driver.set_script_timeout(60)
        try:
            yield driver
        finally:
            driver.quit()


class Page:
    """A page of ``bsm-mesh view`` in a browser.

    Parameters
    ----------
    driver : selenium.webdriver.Chrome
        The browser.
    path : Path
        The page.
    """

    def __init__(self, driver: Any, path: Path) -> None:
        self.driver, self.path = driver, path
        self.open()

    def open(self) -> None:
        """Open the page anew."""
        from selenium.common.exceptions import TimeoutException
        from selenium.webdriver.support.ui import WebDriverWait

        self.driver.get(self.path.as_uri())
        try:
            WebDriverWait(self.driver, 60).until(lambda _: self.title())
        except TimeoutException:
            raise AssertionError(f"nothing was drawn: {self.errors()}") from None
        self.driver.execute_async_script(DRAWN)

    def errors(self) -> list[str]:
        """Return what the browser complains of since the last call."""
        return [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")]

    def title(self) -> str:
        """Return what the page says that it shows."""
        return str(self.driver.execute_script("return Bokeh.documents[0]?.get_model_by_name('plot')?.title.text ?? ''"))

    def text(self, name: str) -> str | None:
        """Return the text of a widget; None before it is there."""
        return self.driver.execute_script(f"return window.Bokeh?.documents[0] ? {MODEL}?.text : null", name)  # type: ignore[no-any-return]

    def told(self) -> dict[str, str]:
        """Return the record of the thing that was chosen, "" its name."""
        return dict(
            self.driver.execute_script(
                f"""const box = document.createElement("div"); box.innerHTML = {MODEL}.text;
                const rows = [...box.querySelectorAll("tr")].map((row) => [...row.children].map((c) => c.textContent));
                return [["", box.querySelector("b")?.textContent ?? ""], ...rows]""",
                "told",
            )
        )

    def drawn(self, kind: str) -> list[list[list[float | None]]]:
        """Return x and y of the shapes of a kind, as lists; None in the gaps of lines."""
        return self.driver.execute_script(  # type: ignore[no-any-return]
            """const plot = Bokeh.documents[0].get_model_by_name("plot");
            const {xs, ys} = plot.renderers.find((one) => one.name === arguments[0]).data_source.data;
            return [xs, ys].map((lines) => Array.from(lines, (line) => Array.from(line)))""",
            kind,
        )

    def set(self, name: str, value: object, key: str = "value") -> None:
        """Set a widget, and wait until that is drawn."""
        self.driver.execute_script(f"{MODEL}[arguments[1]] = arguments[2]", name, key, value)
        self.driver.execute_async_script(DRAWN)

    def click(self, x: float, y: float) -> None:
        """Click on a point [m] of the plot."""
        from selenium.webdriver.common.action_chains import ActionChains

        at = self.driver.execute_script(
            """const view = Bokeh.index.find_one(Bokeh.documents[0].get_model_by_name("plot"));
            const box = view.canvas_view.el.getBoundingClientRect();
            const {x_scale, y_scale} = view.frame;
            return [box.left + x_scale.compute(arguments[0]), box.top + y_scale.compute(arguments[1])]""",
            x,
            y,
        )
        actions = ActionChains(self.driver)
        actions.w3c_actions.pointer_action.move_to_location(*(round(pixel) for pixel in at))
        actions.w3c_actions.pointer_action.click()
        actions.perform()
        self.driver.execute_async_script(DRAWN)
        self.driver.execute_async_script(DRAWN)

    def zoom(self, x: float, y: float, metres: float) -> None:
        """See so many metres of the plot, along y, round a point [m]."""
        self.driver.execute_script(
            """const {x_range, y_range, inner_width, inner_height} = Bokeh.documents[0].get_model_by_name("plot");
            const [x, y, metres] = arguments, half = (metres * inner_width) / inner_height / 2;
            x_range.setv({start: x - half, end: x + half});
            y_range.setv({start: y - metres / 2, end: y + metres / 2})""",
            x,
            y,
            metres,
        )
        self.driver.execute_async_script(DRAWN)

    def picture(self) -> bytes:
        """Return the visible part, as PNG."""
        return bytes(self.driver.get_screenshot_as_png())

    def seconds_a_movement(self, turns: int = 20) -> tuple[float, float]:
        """Return how long it takes to draw other movements, in the mean: by the clock, and of processors [s]."""
        before, spent = time.perf_counter(), self._processor_seconds()
        self.driver.execute_async_script(
            """const [turns, done] = arguments;
            const factor = Bokeh.documents[0].get_model_by_name("factor");
            let left = turns;
            const turn = () => {
              if (left-- === 0) { done(true); return }
              factor.value = factor.categories[left % factor.categories.length];
              requestAnimationFrame(() => setTimeout(turn));
            };
            turn()""",
            turns,
        )
        return (time.perf_counter() - before) / turns, (self._processor_seconds() - spent) / turns

    def _processor_seconds(self) -> float:
        """Return the time that all processes of the browser have had on processors [s]."""
        import psutil

        processes = psutil.Process(self.driver.service.process.pid).children(recursive=True)
        return sum(sum(process.cpu_times()[:2]) for process in processes)

    def seconds_to_open(self) -> float:
        """Return the time from the begin of loading until the first picture was painted [s]."""
        return float(
            self.driver.execute_script("return performance.getEntriesByName('bsm-mesh drawn')[0].startTime") / 1000
        )
