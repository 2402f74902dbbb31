"""Print the final estimate of each pinch: python examples/live_callback.py."""

import firstcontact as fc


def main() -> None:
    """Follow five pinches of the simulated hand with the model of the package."""
    with fc.open("twin") as source:
        for event in fc.live(source, pinches=5):
            if isinstance(event, fc.Estimate) and event.final:
                print(f"{event.value:.0f} Shore A, from {1e3 * event.elapsed:.0f} ms")


if __name__ == "__main__":
    main()
