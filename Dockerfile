# The demo in a container: docker build -t palpate . && docker run --rm palpate
FROM python:3.12-slim-bookworm
RUN apt-get update && apt-get install -y --no-install-recommends g++ git make && rm -rf /var/lib/apt/lists/*
WORKDIR /palpate
COPY . .
RUN make .venv/.demo
CMD ["make", "demo", "ARGS=--headless --duration 5"]
